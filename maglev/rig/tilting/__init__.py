"""Writers of what a platform that tilts has of its own."""
