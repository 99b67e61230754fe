"""A problem and a mesh in; a Pyomo model whose constraints are the defects out."""
