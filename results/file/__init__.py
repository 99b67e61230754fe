"""A Solution in, an HDF5 file out, and the way back: the only place that knows the layout of the file."""
