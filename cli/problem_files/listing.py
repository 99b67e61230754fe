"""`trajopt list`: the problems that ship, all of them or those with some tags."""

from __future__ import annotations

from typing import Annotated

import typer

from ...problems.errors import Mistake, SpecError
from ...problems.text import brief, did_you_mean
from ..errors import command
from ..output.printing import print_table

Tags = Annotated[
    list[str] | None,
    typer.Option("--tag", metavar="TAG", help="Only problems with this tag; given again, with all of them."),
]


@command
def list_(tag: Tags = None) -> None:
    """List the shipped problems; each can be solved by its name.

    Example: trajopt list --tag minimum-time --tag robotics
    """
    from ...problems.catalog import listed

    problems = listed()
    known = sorted({word for entry in problems.values() for word in entry.tags})
    wanted = set(tag or ())
    if unknown := wanted.difference(known):
        raise SpecError(_no_such_tag(word, known) for word in sorted(unknown))
    rows = []
    for name, entry in problems.items():
        if wanted <= set(entry.tags):
            reference = "" if entry.reference is None else f"{entry.reference:.10g}"
            rows.append((name, entry.name, reference, ", ".join(entry.tags), entry.source))
    print_table(("name", "problem", "reference", "tags", "source"), rows)


def _no_such_tag(word: str, known: list[str]) -> Mistake:
    remedy = did_you_mean(word, known, otherwise=f"the tags are {', '.join(known)}")
    return Mistake("--tag", f'no shipped problem has the tag "{brief(word)}"', remedy)
