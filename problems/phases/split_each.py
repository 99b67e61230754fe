"""The phases of a file, each made as many as its solution has arcs: boost becomes boost_1, boost_2, ...

What a phase says of its two ends is then of the first and of the last of them: its times and values there, its boundary
constraints and terminal term, which move to the top level, and what links and the top level say of boost.m[final].
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from itertools import pairwise
from typing import Any

import yaml

from ..expressions.expression import Expression
from ..expressions.tree import Name
from ..names.troubles import INTEGRAL
from ..schema.phases import NONE, LinkEntry, PhaseEntry
from ..schema.spec import Spec
from .merge import phases_as_written
from .order import own_entries
from .split import (
    PhasePart,
    arc,
    bounds_of_time,
    data_of,
    filled,
    integral_states,
    named_paths,
    plain_file,
    split_alone,
)

_BOUNDS = ("lower", "upper", "equals")
_OF_ALL = ("waypoints", "phases", "links")
_OF_ENDS = ("time", "guess", "mesh", "constraints", "note", "objective")

METHOD = {"method": "radau", "segments": 2, "degree": 8}
"""The first mesh of an arc, on which the solution is smooth."""

MOST_MESHES = 6
"""After the first one: an arc that is smooth needs fewer."""

DURATION = "[duration]"
"""After a time: which stands for the difference of two."""


def split(
    spec: Spec, parts: Mapping[str, Sequence[PhasePart]], tolerance: float, refine: float, iterations: int | None = None
) -> str:
    """A problem file in which every part is a phase, as text.

    spec: see `split.why_not`.
    parts: of each phase, by its name, in order; two or more in all.
    tolerance: of the engine.
    refine: the relative error to which the meshes are refined.
    iterations: of the engine on each mesh, at most; None for as many as the file allows.
    """
    data = _Split(spec, parts).data(plain_file(spec)) if own_entries(spec) else split_alone(spec, *parts.values())
    data |= {"mesh": [METHOD | {"tolerance": tolerance}], "refine": {"tolerance": refine, "max_meshes": MOST_MESHES}}
    if iterations is not None:
        solver = data.get("solver", {})
        data["solver"] = {**solver, "max_iter": min(iterations, solver.get("max_iter", iterations))}
    return yaml.safe_dump(data, sort_keys=False, allow_unicode=True, width=118)


class _Split:
    """A file with phases, and the parts of each.

    spec: it.
    parts: phase -> its parts, in order.
    """

    def __init__(self, spec: Spec, parts: Mapping[str, Sequence[PhasePart]]) -> None:
        self.spec, self.parts = spec, parts
        self.entries, self.merged = own_entries(spec), phases_as_written(spec)
        taken = set(self.entries)
        self.names: dict[str, list[str]] = {}
        for name, own in parts.items():
            stem = name
            while len(own) > 1 and any(f"{stem}_{k + 1}" in taken for k in range(len(own))):
                stem += "_"
            self.names[name] = [f"{stem}_{k + 1}" for k in range(len(own))] if len(own) > 1 else [name]

    def data(self, shared: dict[str, Any]) -> dict[str, Any]:
        """The file as plain data.

        shared: what the top level says, without phases.
        """
        constraints = dict(shared.get("constraints", {}))
        constraints.pop("path", None)
        boundary = [self._condition(entry, None) for entry in self.spec.constraints.boundary]
        terminal = self.spec.objective.terms.terminal
        terms = [] if terminal is None else [self._told(terminal, None)]
        phases: dict[str, Any] = {}
        for name, own in self.entries.items():
            boundary += [self._condition(entry, name) for entry in own.constraints.boundary]
            if own.objective and own.objective.terms.terminal is not None:
                terms.append(self._told(own.objective.terms.terminal, name))
            phases |= self._phases(name, own)
        sense = self.spec.objective.sense
        objective = {**(shared.get("objective", {}).get(sense) or {})}
        objective.pop("terminal", None)
        if terms:
            objective["terminal"] = " + ".join(f"({term})" for term in terms)
        return {
            **{key: value for key, value in shared.items() if key not in _OF_ALL},
            "objective": {sense: objective},
            "constraints": {**constraints, "boundary": boundary},
            "phases": phases,
            "links": self._links(),
        }

    def _phases(self, name: str, entry: PhaseEntry) -> dict[str, Any]:
        """The phases that one becomes."""
        merged, parts, own = self.merged[name], self.parts[name], data_of(entry)
        kept = {key: value for key, value in own.items() if key not in _OF_ENDS}
        sense = self.spec.objective.sense
        if (integral := own.get("objective", {}).get(sense, {}).get("integral")) is not None:
            kept["objective"] = {sense: {"integral": integral}}
        kept["states"] = kept.get("states", {}) | {
            state: {"rate": rate, "initial": 0, "final": bounds}
            for state, (rate, bounds) in integral_states(merged, name).items()
        }
        paths, last, found = named_paths(merged), len(parts) - 1, {}
        for k, (part, named) in enumerate(zip(parts, self.names[name], strict=True)):
            phase = deepcopy(kept)
            for state in phase["states"].values():
                _leave_out(state, k > 0, k < last)
            of_arc = arc(merged, part, paths)
            for group in ("states", "controls"):
                given = phase.setdefault(group, {})
                given |= {key: given.get(key, {}) | value for key, value in of_arc.get(group, {}).items()}
            time = {end: value for end, value in own.get("time", {}).items() if end == "final" or k == 0}
            if k < last:
                time["final"] = bounds_of_time(merged) | {"guess": part.end}
            found[named] = filled({**phase, "time": time, "constraints": of_arc.get("constraints")})
        return found

    def _links(self) -> list[Any]:
        """The links, and what goes on within a phase where nothing goes on by itself."""
        apart = any(link.apart for link in self.spec.links)
        found: list[Any] = [self._link(link) for link in self.spec.links]
        for names in self.names.values():
            found += [{"from": a, "to": b} for a, b in pairwise(names) if apart]
        return found

    def _link(self, link: LinkEntry) -> Any:
        if link.apart:
            return NONE
        if link.expression is not None:
            return self._condition(link, None)
        ends = {"from": self.names[link.source][-1], "to": self.names[link.target][0]}
        return ends | ({"except": list(link.left_out)} if link.left_out else {})

    def _condition(self, entry: Any, phase: str | None) -> dict[str, Any]:
        """A condition on the ends of phases; phase: the one whose own it is."""
        bounds = {key: self._told(own, phase) for key in _BOUNDS if (own := getattr(entry, key)) is not None}
        name = {"name": entry.name} if entry.name else {}
        return {**name, "expression": self._told(entry.expression, phase), **bounds}

    def _told(self, expression: Expression, phase: str | None) -> str:
        """The text of an expression with the names of the new phases."""
        text = expression.text
        spans = {(leaf.start, leaf.stop): leaf for leaf in expression.leaves}  # one of the two that t[duration] is
        for (start, stop), leaf in sorted(spans.items(), reverse=True):
            lasting = text[start:stop].endswith(DURATION)
            text = text[:start] + self._name(leaf, phase, lasting) + text[stop:]
        return text

    def _name(self, leaf: Name, phase: str | None, lasting: bool) -> str:
        """What a name is called at the top level of the new file; lasting: whether it is a duration."""
        owner, dot, inner = leaf.name.rpartition(".")
        if not dot or leaf.name.startswith(INTEGRAL):
            owner, inner = phase or "", leaf.name
        end = DURATION if lasting else f"[{leaf.end}]" if leaf.end else ""
        local = bool(dot) or bool(leaf.end) or (phase and inner in self._of_phase(phase))
        if owner not in self.names or not local or leaf.name.startswith(INTEGRAL):
            return f"{leaf.name}{end}"
        first, last = self.names[owner][0], self.names[owner][-1]
        if lasting:
            return f"({last}.{inner}[final] - {first}.{inner}[initial])"
        return f"{last if leaf.end == 'final' else first}.{inner}{end}"

    def _of_phase(self, phase: str) -> set[str]:
        return {*self.entries[phase].parameters, *self.entries[phase].expressions}


def _leave_out(state: dict[str, Any], initial: bool, final: bool) -> None:
    """Take the end values of a state away, and those of its velocity."""
    for own in (state, state.get("velocity", {})):
        for end, out in (("initial", initial), ("final", final)):
            if out:
                own.pop(end, None)
