"""How a block becomes an FMU: variable table, pythonfmu slave, model description, documentation, build."""
