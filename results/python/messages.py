"""Mistakes in the words of Python users: what the command line calls --set is an override here, and so on."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace

from ...problems.errors import Mistake, TrajoptError

REMEDIES = (
    (r"give it on the command line: --set (\S+)=\.\.\.", r'give it as an override: {"\1": ...}'),
    (r"--set (\S+)=\.\.\.", r'the override {"\1": ...}'),
    (r"with --set\b", "as an override"),
    (r"with --guess\b", "with guess="),
    (r"file with -o\b", "file"),
    (r"with --force\b", "with force=True"),
    (r"its name and its folder$", "its name and its folder; the text of a problem file has a line break in it"),
    (r"a file written by 'trajopt solve'", "a file that a solution was saved to"),
    (r"a result written by 'trajopt solve'", "a file that a solution was saved to"),
)
"""Pattern in a remedy -> what a Python user does instead."""


def remedy_in_python(remedy: str) -> str:
    """A remedy that names options of the command line, for those who have none."""
    for pattern, words in REMEDIES:
        remedy = re.sub(pattern, words, remedy)
    return remedy


@contextmanager
def python_words() -> Iterator[None]:
    """Errors of the user's that are raised inside speak of overrides and arguments."""
    try:
        yield
    except TrajoptError as error:
        raise type(error)(map(_in_python, error.mistakes)) from error


def _in_python(mistake: Mistake) -> Mistake:
    where = re.sub(r"^--set ", "override ", mistake.where)
    return replace(mistake, where=where, remedy=remedy_in_python(mistake.remedy))
