"""The bus: typed endpoints and one loop per service over Zenoh; the only code that imports it."""
