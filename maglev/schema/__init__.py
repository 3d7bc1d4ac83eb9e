"""The TOML files: scenarios, signals, claims, procedures."""
