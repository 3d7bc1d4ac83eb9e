"""Maps that come with the package: how far each law can go, and what it tolerates."""
