"""What runs in the place of something else: ports, settings, units."""
