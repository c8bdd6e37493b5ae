"""The experiments of the papers, redone on the services' own mathematics, without a bus."""
