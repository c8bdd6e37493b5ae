"""Pure mathematics shared by the services: arrays in, arrays out; no clock, file, log or bus."""
