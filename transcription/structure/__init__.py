"""A solved program in; what it shows beside its solution out: its kind, the worth of bounds, how exact estimates are."""
