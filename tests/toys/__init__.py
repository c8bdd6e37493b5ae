"""Services that do nothing but live, for tests of what keeps services alive."""
