"""YAML text and overrides in; plain data with the line of every value out."""
