"""The topological map: doors, corners and passages, and the nodes that are bound to them."""
