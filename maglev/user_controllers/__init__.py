"""Controllers that users write as a Python class: found in a file, checked, carried into FMUs; a file to begin with."""
