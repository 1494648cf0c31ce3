"""Whatever holds joint values over time, as one `JointLog`."""
