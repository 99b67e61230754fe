"""Exported programs and formulas."""
