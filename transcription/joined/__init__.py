"""One nonlinear program made of those of several methods, joined by links between phases."""
