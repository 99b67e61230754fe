"""Parts of a first trajectory: rows of values over time, rates of positions, a simulation of the dynamics."""
