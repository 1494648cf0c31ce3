"""Gaits written as recordings."""
