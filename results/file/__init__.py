"""A Solution in, an HDF5 file out, and the way back: only this room and `declared` know the layout of the file."""
