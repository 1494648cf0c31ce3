"""Consecutive steps, as data."""
