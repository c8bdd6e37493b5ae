"""The contract of Pilotage: every message on the bus, its wire format and its topic."""
