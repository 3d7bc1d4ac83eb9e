"""Processes beside this one, tasks in them, and the interrupts that end them."""
