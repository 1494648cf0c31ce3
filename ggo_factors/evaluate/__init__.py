"""What a gait is like, in numbers."""
