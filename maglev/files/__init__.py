"""Files, processes, units, tables and errors: what everything else stands on."""
