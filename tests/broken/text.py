"""Mistakes of a text: what cannot be read, what is no YAML, and values that are none of ours."""

from .case import Case, edit, raw
from .good import GOOD

ALIASES = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)

FILES = [
    Case("a missing file", None, "", "there is no such file", kind="file"),
    Case("a folder", None, "", "this is a folder", kind="file"),
    Case("a dangling link", None, "", "there is no such file", kind="file"),
    raw("an empty file", "", "", "the file is empty"),
    raw("only comments", "# nothing\n\n", "", "the file is empty"),
    raw("a huge file", "#" * 2_000_000, "", "larger than 1 MB"),
    raw("binary junk", bytes(range(256)) * 8, ":2", "UTF-8"),
    raw("binary zeros", b"trajopt: 1\n\x00\x00\x00", ":2", "not a text file"),
    raw("an HDF5 file", b"\x89HDF\r\n\x1a\n" + bytes(100), "", "this is a result, not a problem file"),
    raw("Latin-1 text", "trajopt: 1\nname: Brücke\n".encode("latin-1"), ":2", "save the file as UTF-8"),
    raw("a list", "- 1\n- 2\n", ":1", "not a mapping"),
    raw("a word", "hello\n", ":1", "not a mapping"),
    raw("two documents", GOOD + "---\n" + GOOD, ":33", "keep one problem in a file"),
    raw("a YAML bomb", ALIASES, ":6", "remove aliases"),
    raw("a self-reference", "a: &a [*a]\n", ":1", "refers to no anchor"),
    raw("many aliases", "a: &a 1\nb: [" + "*a, " * 200 + "]\n", ":2", "more than 100 aliases"),
    raw("deep brackets", "a: " + "[" * 100_000, ":1", "nested deeper"),
    raw("deep braces", "a: 1\nb: " + "{c: " * 5_000, ":2", "nested deeper"),
    raw("deep lists", "a:\n  - b\n  " + "- " * 5_000, ":3", "nested deeper"),
    raw("deep indentation", "".join(" " * i + "a:\n" for i in range(500)), ":22", "nested deeper"),
    raw("many values", "a: [" + "1," * 400_000 + "]", ":1", "more than 300000 values"),
    raw("a Python tag", "a: !!python/object/apply:os.system ['true']\n", ":1", "the tag"),
    raw("a Python tag on a key", "!!python/name:os.system a: 1\n", ":1", "the tag"),
    raw("a list as a key", "? [1, 2]\n: 3\n", ":1", "a key must be a word"),
    edit("a tab", "  u_max: 5", "\tu_max: 5", "", "indent with spaces"),
    edit("a wrong indentation", "  d: 1.0", "   d: 1.0", "", "indent keys of one mapping alike"),
    edit("an open brace", "unit: kg}", "unit: kg", "", "close it: m: {value: 2.0, unit: kg}", line=4),
    edit("an open quote", '"x[final] - x[initial]"', '"x[final] - x[initial]', "", "close the quotes"),
    edit("brackets without quotes", '"x[final] - x[initial]"', "x[final] - x[initial]", "", "in quotes"),
    edit("a duplicate key", "  d: 1.0", "  m: 1.0", "parameters.m", "given twice, first on line 4"),
    edit("a duplicate section", "solver:", "mesh:", "mesh", "first on line 29"),
]
