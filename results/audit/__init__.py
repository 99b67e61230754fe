"""The checks of `verify`: a reloaded result in, measures with their limits out."""
