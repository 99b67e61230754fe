"""Pyomo templates in; machine code of values, Jacobian and Hessian at all points at once out."""
