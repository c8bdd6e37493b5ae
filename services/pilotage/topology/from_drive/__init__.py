"""A topological map that grows while the robot drives."""
