"""What names mean in a text of a file or of a phase in it: which are vectors, and which are functions."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from ..expressions.signature import name_trouble, signature
from ..expressions.slips import RESERVED
from ..language.ranges import Mistaken, whole
from ..schema.tables import called_names
from ..yaml.document import Path
from ..yaml.locations import Finding
from .algebra import Scalar, Shape, Value, each_mapped, shape_in_words, shape_of
from .misfits import Misfit, Vector
from .parsed import names_in
from .reader import evaluate, is_of_vectors
from .texts import OWN, FileFunction

INTEGRAL = "integral"
DECLARED = ("states", "controls", "algebraic", "optimize")
"""Sections whose vectors say their size."""
DEFINED = ("parameters", "expressions", "integrals")
"""Sections whose vectors have the size of their value."""
OTHERS = ("tables", "phases", INTEGRAL)
"""What else has names in expressions."""
LARGEST = 100  # components of a vector
LARGEST_MATRIX = 9  # rows and columns: R12 is row 1, column 2
RATES = ("rate", "accel", "next")


class Names:
    """The names of a file, or of one phase in it: a `texts.Scope`."""

    def __init__(self, data: Mapping[str, Any], numbers: Mapping[str, int | str], above: Names | None, path: Path):
        """The names of some data.

        data: of the file, or of a phase.
        numbers: parameters that are whole numbers: what a size may be.
        above: the names of the file, for those of a phase.
        path: of the data.
        """
        self.data, self.numbers, self.above, self.path = data, numbers, above, path
        self.called: frozenset[str] = above.called if above else called_names(data)
        self.findings: list[Finding] = []
        self.misfits: list[Misfit] = []
        self.counted: set[str] = set()
        self.vectors: dict[str, Value] = {}
        self.defined: dict[str, Any] = {}
        self.waiting: set[str] = set()  # names whose value is being looked at
        self.guessed: set[str] = set()  # vectors of which nobody knows the size
        self.functions: dict[str, FileFunction] = {}
        for section in DEFINED:
            self._define(entries_of(data, section))
        for section in DECLARED:
            for name, entry in entries_of(data, section).items():
                if isinstance(entry, dict) and ("size" in entry or _listed(entry, RATES)):
                    self._declare(name, entry, (*path, section, name))
        self.phases: dict[str, Names] = {}
        self._infer()
        for name, own in entries_of(data, "phases").items():
            if isinstance(own, dict):
                self.phases[name] = Names(own, numbers, self, ("phases", name))

    def _define(self, entries: Mapping[str, Any]) -> None:
        for name, entry in entries.items():
            value = entry.get("value") if isinstance(entry, dict) else entry
            if (own := signature(name)) is None:
                self.defined[name] = value
            elif isinstance(value, str):
                self.functions[own.name] = FileFunction(own.arguments, value, False)

    def _declare(self, name: str, entry: Mapping[str, Any], path: Path) -> None:
        try:
            if trouble := name_trouble(name, (*RESERVED, *OWN)):
                self.findings.append(Finding(path, *trouble))
            if "size" not in entry:
                what = f"{name} is one value, and this is a list of {_listed(entry, RATES)}"
                raise Mistaken(what, f"write size: {_listed(entry, RATES)} beside it")
            shape = self._shape(entry["size"])
            before = self.above.vectors.get(name) if self.above else None
            if before is not None and shape_of(before) != shape:
                raise Mistaken(f"{name} is {shape_in_words(shape_of(before))} at the top level", "leave size: out here")
        except Mistaken as mistake:
            key = next(key for key in ("size", *RATES) if key in entry)
            self.findings.append(Finding((*path, key), mistake.what, mistake.remedy))
            shape = (_listed(entry, entry) or 3,)  # what it seems to be
            self.guessed.add(name)
        self._make(name, entry, shape)

    def _make(self, name: str, entry: Mapping[str, Any], shape: Shape) -> None:
        self.vectors[name] = components(shape, lambda index: f"{name}{index}")
        velocity = entry.get("velocity")
        if "accel" in entry or velocity is not None:
            given = velocity.get("name") if isinstance(velocity, dict) else None
            own = (lambda index: f"{given}{index}") if given else (lambda index: f"{name}{index}_dot")
            self.vectors[given or f"{name}_dot"] = components(shape, own)

    def _infer(self) -> None:
        """Tell of what has a vector of another size as its rate; what else is due to that is not told."""
        for section in DECLARED:
            for name, entry in entries_of(self.data, section).items():
                key = next((key for key in RATES if isinstance(entry, dict) and isinstance(entry.get(key), str)), "")
                if key and (shape := self._shape_of(entry[key])) and name not in self.guessed:
                    self._compare(name, entry, shape, key, (*self.path, section, name, key))

    def _compare(self, name: str, entry: Mapping[str, Any], shape: Shape, key: str, path: Path) -> None:
        """Compare a name with the shape of its rate, which is at a key of its entry, and at a path of the file."""
        known = self.vector(name)
        own, rate = shape_of(known) if known else (), shape[:1] if shape[1:] == (1,) else shape
        if own == rate or any(map(self.unclear, names_in(entry[key]))):
            return
        size = shape[0] if len(shape) == 1 else list(shape)
        remedy = f"write size: {size}, or make the {key} as long as it is"
        if known is None:
            remedy = f"write size: {size} beside it, or give one component, as in q[1]"
            self._make(name, entry, shape)
            self.waiting.clear()
        told = Finding(path, f"{name} is {shape_in_words(own)}, and its {key} {shape_in_words(shape)}", remedy)
        self.misfits.append(Misfit(told, self.vectors_among([name, *names_in(entry[key])])))
        self.guessed.add(name)

    def _shape(self, size: Any) -> Shape:
        sizes = size if isinstance(size, list) else [size]
        if any(isinstance(own, bool) or not isinstance(own, int | str) for own in sizes) or not 1 <= len(sizes) <= 2:
            raise Mistaken("this is no size", "write a whole number, size: 3, or rows and columns, size: [3, 3]")
        self.counted |= {name for own in sizes for name in re.findall(r"[A-Za-z_]\w*", str(own))}
        shape = tuple(whole(str(own), {}, self.numbers, in_loop=False) for own in sizes)
        most = LARGEST if len(shape) == 1 else LARGEST_MATRIX
        if not all(1 <= own <= most for own in shape):
            raise Mistaken(f"the size is {' by '.join(map(str, shape))}", f"write whole numbers from 1 to {most}")
        return shape

    def vector(self, name: str) -> Value | None:
        """The components of a name, which may be that of a phase, a point, and a name in it; None for a scalar."""
        first, point, inner = name.partition(".")
        if point:
            scope = self if first == INTEGRAL else self.phases.get(first)
            value = scope.vector(inner) if scope else None
            return None if value is None else each_mapped(value, lambda own: Scalar(f"{first}.{own.text}"))
        found = self._own(name)
        if found is not None or name in self.defined:
            return found
        if self.above:
            return self.above.vector(name)
        return next((own for phase in self.phases.values() if (own := phase._own(name)) is not None), None)

    def _own(self, name: str) -> Value | None:
        if name in self.vectors or name not in self.defined or name in self.waiting:
            return self.vectors.get(name)
        self.waiting.add(name)
        if shape := self._shape_of(self.defined[name]):
            self.vectors[name] = components(shape, lambda index: f"{name}{index}")
            self.waiting.discard(name)
        return self.vectors.get(name)  # else it is a scalar, and stays among those that are not looked at again

    def _shape_of(self, value: Any) -> Shape:
        """The shape of a value as the file has it; () for one that is mistaken, of which is told where it stands."""
        if isinstance(value, list):
            if value and isinstance(value[0], list):
                return len(value), max(len(value[0]), 1)
            return (len(value),) if len(value) > 1 else ()
        try:
            found = evaluate(value, self) if isinstance(value, str) else None
        except Mistaken:
            return ()
        return () if found is None else shape_of(found)

    def vectors_among(self, names: Iterable[str]) -> dict[str, Vector]:
        """The vectors among some names, in this order."""
        found = {name: shape_of(own) for name in names if (own := self.vector(name)) is not None}
        return {name: Vector(shape, self._said_at(name)) for name, shape in found.items()}

    def _said_at(self, name: str) -> Path:
        """Where the file says the size of a vector: at its own, or by a list."""
        for section in (*DECLARED, *DEFINED):
            entry = entries_of(self.data, section).get(name)
            if isinstance(entry, dict) and "size" in entry:
                return (*self.path, section, name, "size")
            if isinstance(entry, list):
                return (*self.path, section, name)
        return self.above._said_at(name) if self.above else ()

    def unclear(self, name: str, seen: frozenset[str] = frozenset()) -> bool:
        """Whether nobody knows the size of a name: it is declared nowhere, or mistaken, or made of such names."""
        if name in seen:
            return False
        if name in self.guessed or not self.declares(name):
            return True
        value = self.defined.get(name)
        if isinstance(value, str):
            return any(self.unclear(own, seen | {name}) for own in names_in(value))
        return self.above.unclear(name, seen) if self.above and not self._declares(name) else False

    def declares(self, name: str) -> bool:
        """Whether a name is declared anywhere, or may be."""
        if self.above and self.above.declares(name):
            return True
        return self._declares(name) or any(own._declares(name) for own in self.phases.values())

    def _declares(self, name: str) -> bool:
        data = self.data
        if name in RESERVED or name in self.vectors or name in self.defined or name in self.called or "model" in data:
            return True
        return any(name in entries_of(data, section) for section in (*DECLARED, *OTHERS)) or name in _velocities(data)

    def function(self, name: str) -> FileFunction | None:
        """The function of the file that has the name."""
        own = self.functions.get(name)
        if own is None:
            return self.above.function(name) if self.above else None
        if name not in self.waiting:
            self.waiting.add(name)
            self.functions[name] = own = own._replace(of_vectors=is_of_vectors(own.body, own.arguments, self))
        return own

    def fixed(self, name: str) -> bool:
        """Whether a name has the same value at all times."""
        own = any(name in entries_of(self.data, section) for section in ("parameters", "optimize")) or name == "pi"
        return own or (self.above is not None and self.above.fixed(name))


def _velocities(data: Mapping[str, Any]) -> set[str]:
    """The names of the velocities of states of one value."""
    states = {name: own for name, own in entries_of(data, "states").items() if isinstance(own, dict)}
    named = (own.get("velocity") for own in states.values())
    return {f"{name}_dot" for name in states} | {str(own.get("name")) for own in named if isinstance(own, dict)}


def entries_of(data: Mapping[str, Any], section: str) -> Mapping[str, Any]:
    """The entries of a section; none where it is no mapping."""
    found = data.get(section)
    return found if isinstance(found, dict) else {}


def _listed(entry: Mapping[str, Any], keys: Iterable[str]) -> int:
    """How many items the first list has that stands at one of some keys; 0 if none is there."""
    return next((len(entry[key]) for key in keys if isinstance(entry.get(key), list) and key != "size"), 0)


def components(shape: Shape, name: Callable[[str], str], index: str = "") -> Value:
    """The names of the components of a vector, or of a matrix.

    shape: of it.
    name: of the component with some digits.
    index: the digits so far.
    """
    if not shape:
        return Scalar(name(index))
    return [components(shape[1:], name, f"{index}{i + 1}") for i in range(shape[0])]
