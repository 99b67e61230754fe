"""A spec as the user wrote it in; one in plain expressions, without what only makes files short, out."""
