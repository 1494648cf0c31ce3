"""Many gaits at once."""
