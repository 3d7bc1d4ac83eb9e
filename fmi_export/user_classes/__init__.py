"""Classes that users write as FMUs: what a class declares, its steps at its samples, its slave."""
