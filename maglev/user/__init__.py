"""The user's stages, controllers and plants."""
