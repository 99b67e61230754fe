"""abs, min and max made consistent."""
