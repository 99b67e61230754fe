"""Summaries and tables in; what people and scripts read out."""
