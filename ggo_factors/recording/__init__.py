"""Recordings: MCAP logs in and out."""
