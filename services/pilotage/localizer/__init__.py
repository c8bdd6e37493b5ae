"""The localizer: where the robot is, how sure that is, and where else it could be."""
