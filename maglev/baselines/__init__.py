"""Runs against their committed baselines."""
