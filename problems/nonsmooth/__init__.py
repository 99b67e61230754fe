"""Expressions with abs, min and max in; smooth ones, or ones on slack variables, out."""
