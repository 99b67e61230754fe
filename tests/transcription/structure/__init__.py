"""The arcs of solutions, and polish by them."""
