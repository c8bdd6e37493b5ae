"""A simulated robot in a world drawn as an occupancy map."""
