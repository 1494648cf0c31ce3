"""What every room uses and no gait is known to: checked inputs, files, tables."""
