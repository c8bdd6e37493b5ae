"""What one scan, and the edges of a picture, show: corners, doors and passages."""
