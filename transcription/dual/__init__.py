"""Multipliers of the nonlinear program in; functions of time and measures, as the continuous problem has them, out."""
