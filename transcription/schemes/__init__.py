"""The name of a method in; its nodes, matrices and interpolants, and meshes of it, out."""
