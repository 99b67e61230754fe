"""A solution in; the next mesh out."""
