"""The launcher: starts the processes of a deployment, watches them, restarts what dies or hangs."""
