"""What may be a name: of what a file declares, and of constraints."""

from __future__ import annotations

import re
from collections.abc import Container, Iterator

from ..expressions.lacking import ALIASES, LACKING
from ..expressions.signature import name_trouble, signature
from ..expressions.slips import MAX_NAME, RESERVED
from ..language.times import TimeParameter
from ..names.occurrences import boundary_names, link_names
from ..names.symbols import Symbols
from ..schema.spec import Spec
from ..text import brief
from ..yaml.document import Path
from ..yaml.locations import Finding
from .functions import signature_troubles

_TITLE = re.compile(r"\w[\w -]*")

CALLED = RESERVED.union(LACKING, ALIASES)
"""Names that no table and no function of a file may have: some are told to be missing, with what does their work."""


def declared_names(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """What is wrong with names that a phase declares: they are words, not reserved, and each is declared once.

    spec: of the phase by itself.
    symbols: of the same.
    """
    first: dict[str, str] = {}  # every name so far -> where it was declared
    for group in ("parameters", "expressions", "states", "controls", "algebraic", "optimize", "tables"):
        for name in getattr(spec, group):
            if group == "expressions" and set("()") & set(name):
                yield from _function(name, first)
            elif not isinstance(spec.optimize.get(name), TimeParameter):
                yield from _once((group, name), name, first, CALLED if group == "tables" else RESERVED)
    for state in symbols.states:
        if state.velocity_of:
            yield from _once(state.path, state.name, first, RESERVED)


def _function(key: str, first: dict[str, str]) -> Iterator[Finding]:
    """A name with arguments."""
    path: Path = ("expressions", key)
    yield from signature_troubles(path, key)
    if own := signature(key):
        yield from _once(path, own.name, first, CALLED)


def _once(path: Path, name: str, first: dict[str, str], reserved: frozenset[str]) -> Iterator[Finding]:
    """One name, which `first` has from now on."""
    if trouble := name_trouble(name, reserved):
        yield Finding(path, *trouble)
    elif name in first:
        yield Finding(path, f"{name} is already declared under {first[name]}", "give every name once, in one section")
    first.setdefault(name, str(path[0]))


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
