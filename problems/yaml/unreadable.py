"""What a person has done where PyYAML cannot read a text, and how to mend it."""

from __future__ import annotations

import yaml

from ..errors import Mistake
from .punctuation import slips_of

MAX_LEVELS = 20
TOO_DEEP = f"the file is nested deeper than {MAX_LEVELS} levels", "remove brackets or indentation"

# What PyYAML says -> how to mend it. The first phrase that occurs in its message decides.
_REMEDIES = (
    ("mapping values are not allowed", 'indent keys of one mapping alike, and put a value that holds ": " in quotes'),
    ("',' or '}'", 'close the brace, and put an expression with [ ] or commas in quotes: "q1[final] - d"'),
    ("',' or ']'", 'close the bracket, and put an expression with [ ] or commas in quotes: "q1[final] - d"'),
    ("could not find expected ':'", "write each entry as key: value, and indent keys of one mapping alike"),
    ("expected <block end>", "indent keys of one mapping alike"),
    ("block sequence entries are not allowed", "start the list on a line of its own, one item a line"),
    ("unexpected end of stream", "close the quotes"),
    ("expected alphabetic or numeric", "put a text that starts with * or & in quotes"),
    ("did not find expected key", "indent keys of one mapping alike, and close quotes and brackets"),
    ("undefined alias", "put a text that starts with * in quotes"),
    ("cannot start any token", "put a text that starts with this character in quotes"),
    ("unknown escape character", "use single quotes around the text"),
)


def unreadable(error: yaml.YAMLError, text: str, file: str, line_before: int) -> Mistake:
    """The mistake behind an error of PyYAML.

    error: what it raised.
    text: of the file.
    file: its name in messages.
    line_before: of the last value that was read, from 1, where the error has no place.
    """
    problem = " ".join(str(getattr(error, "problem", None) or error).split())
    mark, lines = getattr(error, "problem_mark", None), text.splitlines()
    if mark is not None and mark.line >= len(lines):
        # what is missing at the end of the file belongs to what was opened before it
        mark = getattr(error, "context_mark", None) or mark
    if mark is None:
        what = f"this is not YAML ({problem})"
        return Mistake(f"{file}:{line_before}", what, "look at this line and the one after it")
    if "maximum nesting depth" in problem:  # libyaml 0.2.6 reads ahead, and stops itself at some 1000 levels
        return Mistake(f"{file}:{mark.line + 1}", *TOO_DEEP)
    if slip := next(slips_of(problem, mark, lines), None):
        number, what, remedy = slip
        return Mistake(f"{file}:{number + 1}", f"this is not YAML ({what})", remedy)
    remedy = next((r for phrase, r in _REMEDIES if phrase in problem), "look at this line and the one above it")
    start = getattr(error, "context_mark", None) or mark
    inside = f" in what starts on line {start.line + 1}" if start.line < mark.line and "," in problem else ""
    return Mistake(f"{file}:{mark.line + 1}", f"this is not YAML ({problem}{inside})", remedy)
