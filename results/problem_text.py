"""The problem file of a result, to be read, changed and solved again."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import yaml

from ..problems.catalog import files_of
from ..problems.files import check_writable, write_whole
from ..problems.yaml.document import read_document
from ..problems.yaml.overrides import as_text, override
from .file.read import read
from .file.summary import summarize

WIDTH = 118


def write_problem(source: Path, target: Path, force: bool = False) -> None:
    """Write the problem file of a result.

    source: a result.
    target: the file to write.
    force: whether an existing file is replaced.

    Raises FileError if the result cannot be read, or the file cannot be written or exists and not `force`.
    """
    text = problem_text(source)
    check_writable(target, force)
    write_whole(target, text)


def problem_text(source: Path) -> str:
    """The problem file of a result as it was given, comments and all.

    source: a result.

    One that was solved with overrides, or that reads CSV files, is written anew with what it was solved with; comments
    at the top say so. Raises FileError if the result cannot be read.
    """
    result, overrides = read(source), as_text(summarize(source)["overrides"])
    if files_of(result.text):
        data, why = _given(result.spec), "with its data, and with every default"
    elif overrides:
        data, _ = override(read_document(result.text, str(source)), overrides)
        why = f"with {', '.join(overrides)}"
    else:
        return result.text if result.text.endswith("\n") else f"{result.text}\n"
    head = "".join(f"# {line}\n" for line in [f"{result.problem}, as it was solved", why])
    return head + yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=WIDTH)


def _given(spec: Any) -> Any:
    """A stored spec without the keys that have no value; in lists, as of measurements, null stays."""
    if isinstance(spec, dict):
        return {key: _given(value) for key, value in spec.items() if value is not None}
    return [_given(value) for value in spec] if isinstance(spec, list) else spec
