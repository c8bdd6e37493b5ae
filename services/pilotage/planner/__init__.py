"""The planner: drives so as to find out where the robot is, then to where it is told."""
