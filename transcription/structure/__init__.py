"""A solved program in; out comes what it shows beside its solution: what kind it is, what its bounds are worth."""
