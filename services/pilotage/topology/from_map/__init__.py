"""A topological map from a finished occupancy map: space, chords, openings, rooms, nodes, ways."""
