"""One component of whatever a file says of a vector: of a list, of a text, of all that stands in a mapping."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from itertools import product
from typing import Any

from ..language.loops import Mistaken
from ..lean.records import dataclass
from ..names.symbols import UNKNOWN
from ..yaml.document import MAX_NODES, Path
from ..yaml.locations import Finding
from .algebra import Scalar, Shape, Value, as_vector, each, in_words, shape_of
from .reader import evaluate
from .scope import DEFINED, RATES, Names

KEPT = frozenset({"except", "note", "source", "file", "color", "from", "to", "relax", "name", "fill", "unit"})
"""Keys whose values are no expressions, and go with every component."""

MISTAKEN = Scalar("?")
"""Stands for a text of whose mistake is told."""

_ONE_VALUE = "name a component, as in q[1], or write dot(a, a), norm(a) or sum(a)"


@dataclass(frozen=True)
class Component:
    """One component of what is said at a path; or all of it, where that is a scalar.

    names: what names mean there.
    path: in the file.
    to: where it is written.
    index, shape: of the component.
    """

    names: Names
    path: Path
    to: Path
    index: tuple[int, ...] = ()
    shape: Shape = ()

    def at(self, key: str | int) -> Component:
        """The same of the value at a key."""
        return replace(self, path=(*self.path, key), to=(*self.to, key))

    def item(self) -> Component:
        """The same of the item of a list that has one for each component."""
        first, *rest = self.index
        return replace(self, path=(*self.path, first), index=tuple(rest), shape=self.shape[1:])

    def of(self, value: Any) -> Any:
        """Its own of a value of the same shape."""
        for i in self.index:
            value = value[i]
        return value


def each_of(value: Value, names: Names, path: Path, to: Path) -> Iterator[Component]:
    """Each component of a name.

    value: of the name.
    names: what names mean there.
    path: of what is said of it.
    to: of the mapping that the components go to.
    """
    shape = shape_of(value)
    for index, own in zip(product(*map(range, shape)), each(value), strict=True):
        yield Component(names, path, (*to, own.text), index, shape)


class Filler:
    """Finds the values of components. origin: path that is written -> that in the file. findings: mistakes."""

    def __init__(self) -> None:
        self.origin: dict[Path, Path] = {}
        self.findings: list[Finding] = []
        self.known: dict[tuple[int, str], Value | None] = {}
        self.made = 0

    def value(self, value: Any, one: Component) -> Any:
        """One component of a value, of a list, or of all values in a mapping. Raises Mistaken if there are too many."""
        self.made += 1
        if self.made > MAX_NODES:
            raise Mistaken(f"the vectors of the file make more than {MAX_NODES} values", "make them smaller")
        if one.to != one.path:
            self.origin[one.to] = one.path
        if isinstance(value, dict):
            return {key: self._inner(key, own, one.at(key)) for key, own in value.items() if key != "size"}
        if isinstance(value, list):
            return self._listed(value, one)
        found = self.evaluated(value, one.names, one.path) if isinstance(value, str) else None
        return value if found is None else self._text(found, one)

    def _listed(self, value: list[Any], one: Component) -> Any:
        if not one.shape:
            return [self.value(own, one.at(i)) for i, own in enumerate(value)]
        if len(value) != one.shape[0]:
            return self._refused(one, f"this is a list of {len(value)}, and has to be {in_words(one.shape)}")
        return self.value(value[one.index[0]], one.item())

    def _text(self, found: Value, one: Component) -> Any:
        if found is MISTAKEN:
            return UNKNOWN
        if isinstance(found, Scalar) and not (one.shape and one.path[-1] in RATES):
            return found.text
        if shape_of(found := as_vector(found) if len(one.shape) == 1 else found) != one.shape:
            return self._refused(one, f"this is {in_words(shape_of(found))}, and has to be {in_words(one.shape)}")
        return one.of(found).text

    def _inner(self, key: str, value: Any, one: Component) -> Any:
        if key == "unit" and isinstance(value, list) and one.shape:
            fits = len(value) == one.shape[0]
            return value[one.index[0]] if fits else self._refused(one, f"there are {len(value)} units") and ""
        if key == "name" and one.path[-2:] == ("velocity", "name") and one.shape:
            vector = one.names.vector(value) if isinstance(value, str) else None
            return value if vector is None else one.of(vector).text
        return value if key in KEPT else self.value(value, one)

    def _refused(self, one: Component, what: str) -> Any:
        if not one.shape and {*one.path[:3:2]} & {*DEFINED}:  # or it would be a vector, too
            self.findings.append(Finding(one.path, "this is a vector made of itself", "give it without itself"))
            return UNKNOWN
        for_all = "" if one.path[-1] in RATES else "one value for all, or "
        remedy = f"write {for_all}as many as there are" if one.shape else _ONE_VALUE
        self.findings.append(Finding(one.path, what, remedy))
        return UNKNOWN

    def evaluated(self, text: str, names: Names, path: Path) -> Value | None:
        """The components of a text; None for one without vectors, and MISTAKEN for a mistaken one, of which is told."""
        if (key := (id(names), text)) not in self.known:
            try:
                self.known[key] = evaluate(text, names)
            except Mistaken as mistake:
                self.findings.append(Finding(path, mistake.what, mistake.remedy))
                return MISTAKEN
        return self.known[key]
