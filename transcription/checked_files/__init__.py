"""Problem files -> all that solving them needs, at once."""
