"""A checked gait or walk as one HTML page that needs nothing else."""
