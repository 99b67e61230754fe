"""A failed solve in; who is to blame - constraint, expression, phase, time - and what would have to give way, out."""
