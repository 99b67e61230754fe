"""A problem and a mesh in; simulated segments with exact derivatives out."""
