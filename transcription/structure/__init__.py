"""A solved program in; out comes what else it shows: its kind, the worth of bounds, how exact estimates are."""
