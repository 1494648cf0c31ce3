"""Several steps on end, as data."""
