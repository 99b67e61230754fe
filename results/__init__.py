"""Result files: a solution <-> HDF5, and what is read off a result alone."""
