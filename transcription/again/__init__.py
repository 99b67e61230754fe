"""A solution of a mesh in; another of the same mesh out, from what the first shows, or the mesh that comes next; or the
same with all that is told of it."""
