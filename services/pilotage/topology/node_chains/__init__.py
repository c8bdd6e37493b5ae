"""An unknown start: the chain of nodes passed, searched in the map."""
