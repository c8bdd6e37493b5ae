"""What the gateway answers over HTTP, by subject."""
