"""What programs of the real-time computer share: their sampling grid, and velocities from measured positions."""
