"""Ways through topological maps, and the maps as files."""
