"""`trajopt sweep`."""
