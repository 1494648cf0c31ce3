"""From a depth camera's points to a terrain with its uncertainty."""
