"""Complementarity: a and b vary, may be zero, and are two things."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Set

from ..expressions.tree import Name, Node, skeleton
from ..names.occurrences import complementarity_names
from ..names.symbols import Symbols
from ..quantities import Range
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding
from .names import title_troubles

Asked = Callable[[Path, Bounded | None], Range | None]
"""(path, entry there) -> its range; None where one of its ends is mistaken."""


def complementarity_mistakes(spec: Spec, symbols: Symbols, given: Set[str], asked: Asked) -> Iterator[Finding]:
    """What is wrong with the entries of a phase, beside unknown names.

    spec, symbols: of the phase.
    given: names of its constraints.
    asked: the range of a variable, and of its ends.
    """
    taken = set(given)
    for i, (entry, name) in enumerate(zip(spec.complementarity, complementarity_names(spec), strict=True)):
        path: Path = ("complementarity", i)
        yield from title_troubles((*path, "name"), name, taken)
        taken.add(name)
        if not all(symbols.sound((*path, side), own) for side, own in entry.sides):
            continue
        if skeleton(entry.a.root) == skeleton(entry.b.root):
            what = "a and b are the same, so that both are zero at every time"
            yield Finding((*path, "b"), what, "name a gap and a force, or make it a constraint: equals: 0")
        for side, own in entry.sides:
            yield from _side(symbols, path, side, own.root, asked)


def _side(symbols: Symbols, path: Path, side: str, root: Node, asked: Asked) -> Iterator[Finding]:
    if symbols.is_constant(root):
        yield Finding((*path, side), f"{side} is a constant", "let it depend on a state or a control")
        return
    if not isinstance(root, Name):
        return
    for variable in symbols.variables:
        if variable.name != root.name:
            continue
        ends = {"its bounds end": asked(variable.path, variable.entry)}
        ends |= {
            f"its {end} value ends": asked((*variable.path, end), getattr(variable.entry, end, None))
            for end in ("initial", "final")
        }
        for words, allowed in ends.items():
            if allowed is not None and allowed.upper < 0:
                what = f"{root.name} may not be negative here, and {words} at {float(allowed.upper):g}"
                yield Finding((*path, side), what, "change that, or write another expression, such as -" + root.name)
