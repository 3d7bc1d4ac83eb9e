"""Tables of numbers, as laboratories, other tools and this project write them: one reader for all that needs one."""
