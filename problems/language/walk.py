"""All expressions of a spec, wherever they stand, and all names of an expression."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

from ..expressions.expression import Expression
from ..expressions.tree import Name, Node, below, rebuilt
from ..schema.fields import Entry, expressions_below
from ..schema.spec import Spec
from ..yaml.document import Path

SECTIONS = (
    *("parameters", "expressions", "time", "states", "controls", "algebraic", "residuals", "optimize", "objective"),
    *("integrals", "nonsmooth", "constraints", "complementarity", "measurements", "guess", "links", "drawing"),
)
"""What holds expressions; those of phases and waypoints are in the specs of the phases."""

Change = Callable[[Path, Expression], Expression]


def expressions_of(spec: Spec) -> Iterator[tuple[Path, Expression]]:
    """Every expression with its path, in the long form of values: ("expressions", "D", "value")."""
    for section in SECTIONS:
        yield from expressions_below(getattr(spec, section), (section,))


def changed(spec: Spec, change: Change) -> Spec:
    """The spec with another expression in place of each.

    spec: of a file or of one phase.
    change: (path, expression) -> the one that takes its place; the same object where nothing changes.
    """
    sections = {section: getattr(spec, section) for section in SECTIONS}
    new = {section: _changed((section,), value, change) for section, value in sections.items()}
    update = {section: value for section, value in new.items() if value is not sections[section]}
    return spec.model_copy(update=update) if update else spec


def _changed(path: Path, value: Any, change: Change) -> Any:
    if isinstance(value, Expression):
        return change(path, value)
    if isinstance(value, list):
        items = [_changed((*path, i), item, change) for i, item in enumerate(value)]
        return items if any(new is not old for new, old in zip(items, value, strict=True)) else value
    if isinstance(value, dict):
        return _other_items(path, value, change) or value
    if isinstance(value, Entry):
        update = _other_items(path, dict(value), change)
        return (
            value.model_copy(update={k: v for k, v in update.items() if v is not getattr(value, k)})
            if update
            else value
        )
    return value


def _other_items(path: Path, items: dict[str, Any], change: Change) -> dict[str, Any]:
    """The items, if one of them changes; else none."""
    new = {key: _changed((*path, key), item, change) for key, item in items.items()}
    return new if any(new[key] is not items[key] for key in items) else {}


def mapped(node: Node, new: Callable[[Name], Node]) -> Node:
    """A tree with what `new` says in place of each of its names."""
    if isinstance(node, Name):
        return new(node)
    return rebuilt(node, [mapped(part, new) for part in below(node)])
