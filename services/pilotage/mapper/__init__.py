"""The mapper: owner of the map; it serves the map file in use."""
