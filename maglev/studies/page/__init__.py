"""What a study found: on a page, in the terminal, and the commands that run samples again."""
