"""What walks, and on what: legs, gaits, terrain, joint limits."""
