"""Plots of the page and of the pictures: which signals they show, made small, with limits and bounds."""
