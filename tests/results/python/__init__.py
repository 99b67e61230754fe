"""`import trajopt`."""
