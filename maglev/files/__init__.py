"""Files, processes, units, tables and errors: the base of all other packages."""
