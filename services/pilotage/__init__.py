"""Pilotage tells a mobile robot where it is: services over Zenoh, mathematics in numpy and numba."""

__version__ = "0.1.0"
