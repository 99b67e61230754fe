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
    from ...problems.catalog import shipped
    from ...problems.load import load

    specs = {name: load(path) for name, path in shipped().items()}
    known = sorted({word for spec in specs.values() for word in spec.tags})
    wanted = set(tag or ())
    if unknown := wanted.difference(known):
        raise SpecError(_no_such_tag(word, known) for word in sorted(unknown))
    rows = []
    for name, spec in specs.items():
        if wanted <= set(spec.tags):
            reference = "" if spec.reference is None else f"{spec.reference.objective:.10g}"
            rows.append((name, spec.name, reference, ", ".join(spec.tags), spec.source))
    print_table(("name", "problem", "reference", "tags", "source"), rows)


def _no_such_tag(word: str, known: list[str]) -> Mistake:
    remedy = did_you_mean(word, known, otherwise=f"the tags are {', '.join(known)}")
    return Mistake("--tag", f'no shipped problem has the tag "{brief(word)}"', remedy)
