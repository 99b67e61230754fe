"""A word of another tool, or a slip, in; what it is here and the line as it should be written, out."""
