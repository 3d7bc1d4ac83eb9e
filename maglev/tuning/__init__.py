"""Tuning: parameters of a controller, or the poles of its axes, searched for the least of what is measured."""
