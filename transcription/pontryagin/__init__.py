"""A solution in; how far its controls are from minimising the Hamiltonian, and a start with those that do, out."""
