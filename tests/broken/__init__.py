"""Broken problem files: each a small edit of a good one, with the place and the words its message must have.

`CASES` is data: each by itself is run by tests/cli/test_cli.py. `write` puts a case on the disk.
"""

from trajopt.transcription.schemes import table as schemes

from .case import Case, write
from .chains import CHAINS
from .complementarity import COMPLEMENTARITY
from .dynamics import DYNAMICS, MODELS
from .ends_over_time import ENDS_OVER_TIME
from .formulas import EXPRESSIONS, NAMES, OVERRIDES
from .functions import FUNCTIONS
from .good import GOOD, IMPLICIT
from .guesses import BAD_GUESS, GUESSES
from .integrals import INTEGRALS
from .loops import LOOPS
from .measurements import BAD_MEASURED, MEASURED, MEASUREMENTS
from .methods import CONSISTENT, RANGES, SOLVERS
from .phases import PHASES
from .tables import BAD_CSV, CSV, TABLES, WITH_TABLES
from .text import FILES
from .timeless import TIMELESS
from .values import KEYS, NUMBERS, STRANGE
from .vectors import VECTORS

__all__ = [
    "BAD_CSV",
    "BAD_GUESS",
    "BAD_MEASURED",
    "CASES",
    "CSV",
    "GOOD",
    "IMPLICIT",
    "MEASURED",
    "METHODS",
    "WITH_TABLES",
    "Case",
    "write",
]

METHODS = tuple(schemes.METHODS)
CASES = [
    *(*DYNAMICS, *MODELS, *CONSISTENT, *RANGES, *SOLVERS, *FILES, *KEYS, *PHASES, *COMPLEMENTARITY),
    *(*NUMBERS, *STRANGE, *NAMES, *EXPRESSIONS, *OVERRIDES, *TABLES, *GUESSES, *FUNCTIONS, *ENDS_OVER_TIME),
    *(*MEASUREMENTS, *TIMELESS, *INTEGRALS, *LOOPS, *VECTORS, *CHAINS),
]
