"""A stage of the user's: its description read and completed, checked, and known to this process as ours are."""
