"""One component of whatever a file says of a vector: of a list, of a text, of all that stands in a mapping."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import prod
from typing import Any

from ..language.ranges import Mistaken
from ..lean.records import dataclass
from ..names.symbols import UNKNOWN
from ..text import tidy
from ..yaml.document import MAX_NODES, Path
from ..yaml.locations import Finding
from ..yaml.punctuation import ends_of_range
from ..yaml.told import Made
from .algebra import Scalar, Shape, Value, as_vector, indexed, shape_in_words, shape_of
from .misfits import Misfit
from .parsed import names_in
from .reader import evaluate
from .scope import DEFINED, RATES, Names

KEPT = frozenset({"except", "note", "source", "file", "color", "from", "to", "relax", "name", "fill", "unit"})
"""Keys whose values are no expressions, and go with every component."""

MISTAKEN = Scalar("?")
"""Stands for a text of whose mistake is told."""
UNDECLARED = -1
"""The level of a scalar that stands for such a text, and has its names that are declared nowhere."""

_ONE_VALUE = "name a component, as in q[1], or write dot(a, a), norm(a) or sum(a)"


@dataclass(frozen=True)
class Component:
    """One component of what is said at a path; or all of it, where that is a scalar.

    names: what names mean there.
    path: in the file.
    to: where it is written.
    index, shape: of the component.
    made: what is told of where it comes from.
    """

    names: Names
    path: Path
    to: Path
    index: tuple[int, ...] = ()
    shape: Shape = ()
    made: Made | None = None

    def at(self, key: str | int) -> Component:
        """The same of the value at a key."""
        made = self.made and self.made._replace(base=(*self.made.base, key))
        return replace(self, path=(*self.path, key), to=(*self.to, key), made=made)

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
    for index, own in indexed(value):
        yield Component(names, path, (*to, own.text), index, shape, Made(path, index, prod(shape)))


class Filler:
    """Finds the values of components.

    origin: path that is written -> that in the file. findings: mistakes; misfits: those of vectors that do not go
    together, and the like. made, texts: as of `told.InWords`.
    """

    def __init__(self) -> None:
        self.origin: dict[Path, Path] = {}
        self.made: dict[Path, Made] = {}
        self.texts: dict[Path, tuple[str, str]] = {}
        self.findings: list[Finding] = []
        self.misfits: list[Misfit] = []
        self.known: dict[tuple[int, str], Value | None] = {}
        self.count = 0

    def value(self, value: Any, one: Component) -> Any:
        """One component of a value, of a list, or of all values in a mapping. Raises Mistaken if there are too many."""
        self.count += 1
        if self.count > MAX_NODES:
            raise Mistaken(f"the vectors of the file make more than {MAX_NODES} values", "make them smaller")
        if one.to != one.path:
            self.origin[one.to] = one.path
        if one.made:
            self.made[one.to] = one.made
        if isinstance(value, dict):
            return {key: self._inner(key, own, one.at(key)) for key, own in value.items() if key != "size"}
        if isinstance(value, list):
            return self._listed(value, one)
        found = self.evaluated(value, one.names, one.path) if isinstance(value, str) else None
        if found is None:
            return value
        written = self._text(found, value, one)
        if isinstance(written, str) and not (isinstance(found, Scalar) and found.level == UNDECLARED):
            self.texts[one.to] = written, tidy(value)
        return written

    def _listed(self, value: list[Any], one: Component) -> Any:
        if not one.shape:
            return [self.value(own, one.at(i)) for i, own in enumerate(value)]
        if len(value) != one.shape[0]:
            return self._refused(one, f"this is a list of {len(value)}, and has to be {shape_in_words(one.shape)}")
        return self.value(value[one.index[0]], one.item())

    def _text(self, found: Value, text: str, one: Component) -> Any:
        if found is MISTAKEN:
            return UNKNOWN
        if isinstance(found, Scalar) and found.level == UNDECLARED:
            return found.text
        if isinstance(found, Scalar) and not (one.shape and one.path[-1] in RATES):
            return found.text
        if shape_of(found := as_vector(found) if len(one.shape) == 1 else found) != one.shape:
            what = f"this is {shape_in_words(shape_of(found))}, and has to be {shape_in_words(one.shape)}"
            return self._undeclared(text, one.names) or self._refused(one, what, text)
        return one.of(found).text

    def _inner(self, key: str, value: Any, one: Component) -> Any:
        if key == "unit" and isinstance(value, list) and one.shape:
            fits = len(value) == one.shape[0]
            return value[one.index[0]] if fits else self._refused(one, f"there are {len(value)} units") and ""
        if key == "name" and one.path[-2:] == ("velocity", "name") and one.shape:
            vector = one.names.vector(value) if isinstance(value, str) else None
            return value if vector is None else one.of(vector).text
        return value if key in KEPT else self.value(value, one)

    def _refused(self, one: Component, what: str, text: str = "") -> Any:
        names = (*names_in(text), *(step for step in one.path if isinstance(step, str)))
        if any(one.names.declares(name) and one.names.unclear(name) for name in names):
            return UNKNOWN  # what is told of that comes first
        if not one.shape and {*one.path[:3:2]} & {*DEFINED}:  # or it would be a vector, too
            self.findings.append(Finding(one.path, "this is a vector made of itself", "give it without itself"))
            return UNKNOWN
        if not one.shape and one.path[-1] in ("initial", "final") and (ends := ends_of_range(text)):
            lower, upper = ends
            remedy = f"write {one.path[-1]}: {{lower: {lower}, upper: {upper}}}"
            self.findings.append(Finding(one.path, "a range is no list", remedy))
            return UNKNOWN
        for_all = "" if one.path[-1] in RATES else "one value for all, or "
        remedy = f"write {for_all}as many as there are" if one.shape else _ONE_VALUE
        self.findings.append(Finding(one.path, what, remedy))
        return UNKNOWN

    def evaluated(self, text: str, names: Names, path: Path) -> Value | None:
        """The components of a text; None for one without vectors, and MISTAKEN for a mistaken one, of which is told.

        text: an expression.
        names: of the file, or of the phase that it stands in.
        path: where a mistake is told.
        """
        if (key := (id(names), text)) not in self.known:
            try:
                self.known[key] = evaluate(text, names)
            except Mistaken as mistake:
                return self._mistaken(mistake, text, names, path)
        return self.known[key]

    def _mistaken(self, mistake: Mistaken, text: str, names: Names, path: Path) -> Value:
        """What stands for a mistaken text: its names that are declared nowhere, if there are such.

        Of what is due to these, and to vectors of unknown size, nothing is told but that.
        """
        concerned = names_in(mistake.text) if mistake.text else ()
        if not any(map(names.unclear, concerned)):
            inside = concerned if mistake.text in tidy(text) else ()  # and not in a function, with names of its own
            self.misfits.append(Misfit(Finding(path, mistake.what, mistake.remedy), names.vectors_among(inside)))
        return Scalar(found, UNDECLARED) if (found := self._undeclared(text, names)) else MISTAKEN

    def _undeclared(self, text: str, names: Names) -> str:
        """The names in a text that are declared nowhere, of which later checks tell, as an expression."""
        return " + ".join(sorted(name for name in names_in(text) if not names.declares(name)))
