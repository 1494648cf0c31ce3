"""The gait graph: from a description, through rounds of GTSAM, to a solution."""
