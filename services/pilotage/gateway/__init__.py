"""The gateway: the robot over HTTP, server-sent events and WebSocket, and the page."""
