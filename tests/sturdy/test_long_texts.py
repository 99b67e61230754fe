"""Texts of 60 000 characters where a few are meant: told at once, by patterns that look at each character once."""

import json

import pytest

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text

LENGTH = 60_000
LONG = {
    "a word": "x" * LENGTH,
    "digits": "1" * LENGTH,
    "spaces": "x" + " " * LENGTH + "y",
    "names in a list": "x, " * (LENGTH // 3),
    "entries": "x: " * (LENGTH // 3),
    "equations": "x = " * (LENGTH // 4),
    "ranges": "1.." * (LENGTH // 3),
    "brackets": "[" * LENGTH,
}
PLACES = [
    ("name",),
    ("controls",),
    ("states", "x", "rate"),
    ("states", "x", "initial"),
    ("controls", "u", "unit"),
    ("parameters", "p"),
    ("guess",),
    ("tables", "t"),
    ("phases",),
]


@pytest.mark.parametrize("text", LONG.values(), ids=LONG)
def test_a_long_text_is_told(text):
    for *above, last in PLACES:
        content = {
            "trajopt": 1,
            "time": {"initial": 0, "final": 1},
            "states": {"x": {"rate": "u", "initial": 0, "final": 1}},
            "controls": {"u": {}},
            "objective": {"minimize": {"integral": "u**2"}},
        }
        inner = content
        for key in above:
            inner = inner.setdefault(key, {})
        inner[last] = text
        with pytest.raises(SpecError) as error:
            load_text(json.dumps(content), "long.yaml")
        assert all(len(str(mistake)) < 1000 for mistake in error.value.mistakes)
