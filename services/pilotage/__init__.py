"""Pilotage tells a mobile robot where it is: services over Zenoh, mathematics in numba."""

__version__ = "0.1.0"
