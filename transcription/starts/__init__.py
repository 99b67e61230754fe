"""Where a solve starts: other first trajectories than the guess, drawn ones, and multipliers of the mesh before."""
