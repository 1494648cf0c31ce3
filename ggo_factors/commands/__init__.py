"""The commands of `ggo`, by what they do."""
