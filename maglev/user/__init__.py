"""Stages, controllers and plants of the user's."""
