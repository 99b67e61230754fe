"""A solved program in; out comes what it shows beside its solution: what kind it is, what bounds are worth, how exact estimates."""
