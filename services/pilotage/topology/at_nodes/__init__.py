"""Which node the robot is at, and the pose that its features give."""
