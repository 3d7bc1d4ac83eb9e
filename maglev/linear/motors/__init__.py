"""What the motors of a rig do to its axes."""
