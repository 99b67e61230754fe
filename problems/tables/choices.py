"""What a table of data may be: its kinds, what is done outside of its points, its size."""

CUBIC, MONOTONE, LINEAR = "cubic", "monotone", "linear"
ERROR, HOLD, EXTRAPOLATE = "error", "hold", "extrapolate"
WAYS = (ERROR, HOLD, EXTRAPOLATE)

MAX_ARGUMENTS = 3
MAX_VALUES = 100_000
