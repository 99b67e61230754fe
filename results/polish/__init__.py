"""A solution in, the same in phases by the arcs that it shows out, where that is better."""
