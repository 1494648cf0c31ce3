"""What every room uses and what knows nothing of gaits: checked inputs, files, tables."""
