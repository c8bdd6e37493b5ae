"""The robot: drivers of real, simulated and recorded ones, and the last word before the wheels."""
