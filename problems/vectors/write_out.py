"""Vectors in the data of a file, `states: {q: {size: 3, rate: cross(w, q)}}`, written out as scalars.

This is done after templates are written out (see `language.loops`), and before anything else looks at the data: a
vector q becomes the entries q1, q2, q3, an expression that is a vector one for each component, and a constraint on it
as many constraints. Whatever is made has the line of what it was made of.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from itertools import chain, product
from math import prod
from types import MappingProxyType
from typing import Any, NamedTuple

from ..expressions.signature import signature
from ..expressions.slips import RESERVED
from ..language.ranges import Mistaken, whole_numbers
from ..names.symbols import UNKNOWN
from ..yaml.document import Path
from ..yaml.locations import Finding
from ..yaml.told import InWords, Made, Named
from .algebra import Scalar, Shape, each, indexed, shape_in_words, shape_of
from .component import KEPT, MISTAKEN, Component, Filler, each_of
from .misfits import told_once
from .scope import DECLARED, DEFINED, Names, entries_of

_ITEMS = {"residuals": ("expression",), "links": ("expression",), "complementarity": ("a", "b")}
"""Lists of what holds -> the keys of their expressions."""
_CONSTRAINT = ("expression",)
_PLAIN = ("time", "objective", "nonsmooth")
_GUESSES = ("constants", "formulas", "simulate", "keyframes")
POINTS = ("line", "point", "circle", "box")
"""Kinds of shapes in a drawing that have points."""
_OF_RATE = re.compile(r"(\w+)(\[rate\])")

SECTIONS = frozenset(
    {*DECLARED, *DEFINED, *_ITEMS, *_PLAIN, "constraints", "without", "waypoints", "guess", "scaling", "drawing"}
    | {"measurements", "phases"}
)
"""What is looked at."""


class WrittenOut(NamedTuple):
    """data: without vectors. origin: path in it -> that in the file. findings: mistakes. counted: parameters that sizes
    go by. in_words: says of vectors what is found of their components."""

    data: dict[str, Any]
    origin: Mapping[Path, Path] = MappingProxyType({})
    findings: Sequence[Finding] = ()
    counted: frozenset[str] = frozenset()
    in_words: InWords = InWords()


def vectors_written_out(data: Mapping[str, Any]) -> WrittenOut:
    """The data of a file with its vectors written out; templates are so already."""
    names = Names(data, whole_numbers(data.get("parameters")), None, ())
    filler = Filler()
    try:
        new = _Writer(names, (), filler).written(data)
    except Mistaken as mistake:
        return WrittenOut({**data}, findings=[Finding((), mistake.what, mistake.remedy)])
    everywhere = [names, *names.phases.values()]
    misfits = [*(misfit for own in everywhere for misfit in own.misfits), *filler.misfits]
    findings = [*(finding for own in everywhere for finding in own.findings), *told_once(misfits), *filler.findings]
    counted = frozenset[str]().union(*(own.counted for own in everywhere))
    in_words = InWords(_components(everywhere), filler.made, filler.texts)
    return WrittenOut(new, filler.origin, findings, counted, in_words)


def _components(everywhere: Sequence[Names]) -> dict[str, Named]:
    """The names that are made, by which nothing else is called."""
    declared = {
        name for own in everywhere for section in (*DECLARED, *DEFINED) for name in entries_of(own.data, section)
    }
    vectors = [(name, value) for own in everywhere for name, value in own.vectors.items() if name not in RESERVED]
    made = {own.text: Named(name, index) for name, value in vectors for index, own in indexed(value)}
    return {text: named for text, named in made.items() if text not in declared}


class _Writer:
    """Writes the data of a file, or of a phase in it, with the names that it has there."""

    def __init__(self, names: Names, path: Path, filler: Filler):
        self.names, self.path, self.filler = names, path, filler
        self.work: dict[str, Callable[[Any, Path], Any]] = {
            **dict.fromkeys((*DECLARED, *DEFINED), self._entries),
            **dict.fromkeys(_PLAIN, self._scalar),
            **{key: partial(self._items, keys) for key, keys in _ITEMS.items()},
            "constraints": self._constraints,
            "without": self._without,
            "waypoints": self._waypoints,
            "guess": self._guess,
            "scaling": self._by_name,
            "drawing": self._drawing,
            "measurements": self._measurements,
            "phases": self._phases,
        }

    def written(self, data: Mapping[str, Any]) -> dict[str, Any]:
        """The data without vectors."""
        return {
            key: self.work[key](value, (*self.path, key))
            if key in self.work and isinstance(value, dict | list)
            else value
            for key, value in data.items()
        }

    def _scalar(self, value: Any, path: Path) -> Any:
        return self.filler.value(value, Component(self.names, path, path))

    def _entries(self, entries: Any, path: Path) -> Any:
        """A section that declares names."""
        if not isinstance(entries, dict):
            return entries
        new: dict[str, Any] = {}
        for name, entry in entries.items():
            here = (*path, name)
            if (own := signature(name)) is not None:
                function = self.names.function(own.name)
                if function is None or not function.of_vectors:  # one of vectors is written out where it is called
                    new[name] = entry
                continue
            value = self.names.vector(name)
            if value is None:
                new[name] = self._scalar(entry, here)
                continue
            made = list(each_of(value, self.names, here, path))
            if twice := next((one.to[-1] for one in made if one.to[-1] in new or one.to[-1] in entries), None):
                what = f"{name} has the component {twice}, and that is declared, too"
                self.filler.findings.append(Finding(here, what, "give one of them another name"))
            new |= {str(one.to[-1]): self.filler.value(entry, one) for one in made}
        return new

    def _by_name(self, entries: Any, path: Path, rows: bool = False) -> Any:
        """Values by the names that they are of. rows: they are lists over time."""
        if not isinstance(entries, dict):
            return entries
        new: dict[str, Any] = {}
        for name, entry in entries.items():
            here, rate = (*path, name), _OF_RATE.fullmatch(name)
            value = self.names.vector(rate[1] if rate else name)
            if value is None and isinstance(entry, list) and not rows:
                new[name] = self._no_vector(name, len(entry), here)
                continue
            if value is None:
                new[name] = entry if rows and name == "time" else self._scalar(entry, here)
                continue
            for one in each_of(value, self.names, here, path):
                key = f"{one.to[-1]}{rate[2] if rate else ''}"
                over_time = rows and isinstance(entry, list)
                new[key] = (
                    [self.filler.value(row, one) for row in entry] if over_time else self.filler.value(entry, one)
                )
        return new

    def _no_vector(self, name: str, count: int, path: Path) -> Any:
        """What stands for a list that is given for one value, or for a name of which later checks tell."""
        if self.names.declares(name):
            what = f"{name} is one value, and this is a list of {count}"
            self.filler.findings.append(Finding(path, what, f"write one number; a vector has size: {count}"))
        return UNKNOWN

    def _items(self, keys: Sequence[str], items: Any, to: Path) -> Any:
        """A list of what holds, with as many items for a vector as it has components."""
        if not isinstance(items, list):
            return items
        new: list[Any] = []
        for i, item in enumerate(items):
            here = (*to, i)
            texts = {(*here, key): item.get(key) for key in keys} if isinstance(item, dict) else {here: item}
            shape = next((own for path, text in texts.items() if (own := self._shape(text, path))), ())
            for index in product(*map(range, shape)):
                made = self.filler.value(
                    item, Component(self.names, here, (*to, len(new)), index, shape, Made(here, index, prod(shape)))
                )
                if isinstance(made, dict) and shape and "name" in made:
                    made["name"] = f"{made['name']} {','.join(str(k + 1) for k in index)}"
                if isinstance(made, dict) and isinstance(made.get("except"), list):
                    made["except"] = self._without(item["except"], here)
                new.append(made)
        return new

    def _shape(self, value: Any, path: Path) -> Shape:
        if isinstance(value, list):
            return (len(value),)
        found = self.filler.evaluated(value, self.names, path) if isinstance(value, str) else None
        return shape_of(found) if found is not None else ()

    def _phases(self, phases: Any, path: Path) -> Any:
        if not isinstance(phases, dict):
            return phases
        return {
            name: _Writer(self.names.phases[name], (*path, name), self.filler).written(own)
            if isinstance(own, dict)
            else own
            for name, own in phases.items()
        }

    def _constraints(self, value: Any, path: Path) -> Any:
        if not isinstance(value, dict):
            return self._items(_CONSTRAINT, value, path)
        return {kind: self._items(_CONSTRAINT, own, (*path, kind)) for kind, own in value.items()}

    def _guess(self, value: Any, path: Path) -> Any:
        if not isinstance(value, dict):
            return value
        return {
            kind: self._by_name(own, (*path, kind), rows=kind == "keyframes") if kind in _GUESSES else own
            for kind, own in value.items()
        }

    def _waypoints(self, value: Any, path: Path) -> Any:
        if not isinstance(value, list):
            return value
        points = [self._by_name(own, (*path, i)) for i, own in enumerate(value)]
        for i, point in enumerate(points):
            if isinstance(point, dict) and isinstance(value[i].get("states"), dict):
                point["states"] = self._by_name(value[i]["states"], (*path, i, "states"))
        return points

    def _measurements(self, value: Any, path: Path) -> Any:
        if not isinstance(value, dict):
            return value
        return {
            name: {**own, "compare": self._scalar(own["compare"], (*path, name, "compare"))}
            if isinstance(own, dict) and "compare" in own
            else own
            for name, own in value.items()
        }

    def _without(self, value: Any, path: Path) -> Any:
        """A list of names."""
        if not isinstance(value, list):
            return value
        vectors = {own: self.names.vector(own) for own in value if isinstance(own, str)}
        names = ([s.text for s in each(vector)] if (vector := vectors.get(own)) else [own] for own in value)
        return list(chain.from_iterable(names))

    def _drawing(self, value: Any, path: Path) -> Any:
        """What a drawing has: a vector is a point, or its x and its y are."""
        if isinstance(value, list):
            return [self._drawing(own, (*path, i)) for i, own in enumerate(value)]
        if isinstance(value, dict):
            return {key: own if key in KEPT else self._drawing(own, (*path, key)) for key, own in value.items()}
        found = self.filler.evaluated(value, self.names, path) if isinstance(value, str) else None
        if found is None:
            return value
        if isinstance(found, Scalar):
            return UNKNOWN if found is MISTAKEN else found.text
        return self._point(found, value, path)

    def _point(self, found: list[Any], text: str, path: Path) -> Any:
        """A vector in a drawing, where a point may stand."""
        shape, (kind, *inside) = shape_of(found), path[path.index("drawing") + 2 :] or ("",)
        points = kind in POINTS and len(inside) == (kind == "line")
        if points and shape == (2,):
            for i, own in enumerate(each(found)):
                self.filler.made[(*path, i)] = Made(path, (i,), 2)
                self.filler.texts[(*path, i)] = own.text, text
            return [own.text for own in each(found)]
        name = text if text.isidentifier() else "q"
        what = f"this is {shape_in_words(shape)}, and {'a point is a vector of 2' if points else 'has to be one value'}"
        remedy = f"write {name}[1..2], or [{name}[1], {name}[2]]" if points else f"name a component, as in {name}[1]"
        self.filler.findings.append(Finding(path, what, remedy))
        return [UNKNOWN, UNKNOWN] if points else UNKNOWN
