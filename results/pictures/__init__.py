"""Curves of a result in; figures and films out."""
