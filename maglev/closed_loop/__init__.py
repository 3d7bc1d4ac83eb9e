"""Controller and plant as one block, stepped in sequence, and the FMUs of it."""
