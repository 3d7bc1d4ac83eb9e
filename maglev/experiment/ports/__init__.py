"""What flies in the place of something else: ports, settings, units."""
