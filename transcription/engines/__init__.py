"""A nonlinear program in; an Outcome out: the point, its multipliers, and what was said of it."""
