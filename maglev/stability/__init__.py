"""Loops whose commands are limited: how far from rest they still come back, with and without anti-windup."""
