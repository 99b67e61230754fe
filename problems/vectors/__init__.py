"""The data of a file with vectors in, the same in scalars out: q of size 3 becomes q1, q2, q3."""
