"""Commands on problem files, and on what ships."""
