"""A Pyomo model in; files for other solvers, or to read, out."""
