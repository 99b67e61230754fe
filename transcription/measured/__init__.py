"""Measurements: a problem with them and a program -> the program with their residuals."""
