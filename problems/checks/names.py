"""What may be a name: of what a file declares, and of constraints."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator

from ..expressions.slips import MAX_NAME
from ..names.occurrences import boundary_names, link_names
from ..schema.spec import Spec
from ..text import brief
from ..yaml.document import Path
from ..yaml.locations import Finding

_TITLE = re.compile(r"\w[\w -]*")


def check_names(spec: Spec) -> Iterator[Finding]:
    """Names of links and of boundary constraints of the top level: words, and each once."""
    given: set[str] = set()
    links = [("links", i) for i, link in enumerate(spec.links) if link.expression is not None]
    paths: list[Path] = [*links, *(("constraints", "boundary", i) for i in range(len(spec.constraints.boundary)))]
    for path, name in zip(paths, link_names(spec) + boundary_names(spec), strict=True):
        yield from title_troubles((*path, "name"), name, given)
        given.add(name)


def title_troubles(path: Path, name: str, given: Container[str]) -> Iterator[Finding]:
    """What is wrong with the name of a constraint.

    path: where it stands.
    name: to be told of in results.
    given: those of the constraints before it.
    """
    if not _TITLE.fullmatch(name) or len(name) > MAX_NAME:
        yield Finding(path, f'"{brief(name)}" cannot be a name', "use letters, digits, _, - and space")
    if name in given:
        yield Finding(path, f'another constraint is called "{name}" too', "give each its own name")
