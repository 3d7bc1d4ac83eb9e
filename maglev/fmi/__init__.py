"""From a block to an FMU: Python and native, FMI 2.0 and 3.0, and its pages."""
