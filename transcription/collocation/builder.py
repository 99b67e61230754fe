"""What the builders of all methods share: the variables of a phase, its constraints, its integrals.

A method says at which places the problem's functions are evaluated (`Place`) and adds the dynamics; path constraints,
residuals, bounds of states that are no variables, and integrals follow from the places alone.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable, Mapping
from typing import Any

import numpy as np

from ...problems.conserved.determined import Determined, needed_at, open_at
from ...problems.probe import names_asked
from ...problems.problem import Curves, Phase
from ...problems.quantities import Constraint as PathConstraint
from ...problems.quantities import Function, Range
from ..constraint_kinds import (
    BOUNDARY,
    CONDITION,
    INTEGRAL,
    PATH,
    PATH_END,
    RESIDUAL,
    RESIDUAL_END,
    ConstraintKind,
    range_of_state,
)
from ..layout import Family
from ..libraries.pyomo import AnyValue, Constraint, Param, RangeSet, Set, Var, pyomo
from ..program.templates import item
from ..schemes.mesh import Mesh
from .place import Place, Values
from .relations import between, bound, finite


class PhaseBuilder(ABC):
    """Fills the block of one phase; a method is a subclass with `stored`, `places`, `dynamics` and `end_values`."""

    def __init__(self, block: Any, p: Mapping[str, Any], data: Mapping[str, Any], phase: Phase, mesh: Mesh) -> None:
        """p: the static parameters by name; data: what stands for the parameters of the file that are data."""
        self.block, self.p, self.phase, self.mesh = block, p, phase, mesh
        self.constants = {**p, **data}
        self.last = len(mesh.fractions) - 1
        self.families: list[Family] = []
        self.owners: dict[str, np.ndarray] = {}
        self.shared: dict[str, tuple[np.ndarray, np.ndarray, np.ndarray]] = {}
        self.explicit_set: Any = None
        self.before: PhaseBuilder | None = None  # of the phase whose time goes on in this one

    @abstractmethod
    def stored(self) -> tuple[list[str], np.ndarray]:
        """The states that are variables, and the points at which they are."""

    @abstractmethod
    def places(self) -> list[Place]:
        """Every collocation point, once."""

    @abstractmethod
    def dynamics(self) -> None:
        """Add the defects."""

    @abstractmethod
    def end_values(self, last: bool) -> Values:
        """The values at the first or at the last point."""

    # -- variables and data ------------------------------------------------------------------------------------

    def variables(self, guess: Curves) -> None:
        block, phase, mesh = self.block, self.phase, self.mesh
        for name, bounds, value in (
            ("t0", phase.initial_time, guess.initial_time),
            ("tF", phase.final_time, guess.final_time),
        ):
            block.add_component(name, Var())
            bound(block.component(name), bounds, bounds.clip(value))  # a fixed time is not the guess's
            block.component(name).fixed = bounds.fixed
        block.point, block.segment = RangeSet(0, self.last), RangeSet(0, mesh.segments - 1)
        if _uses_time(phase):
            self.data("fraction", block.point, mesh.fractions)
        names, points = self.stored()
        block.x = Var(names, self.points("stored", points))
        collocated = self.points("collocated", mesh.collocated)
        block.u = Var([control.name for control in phase.controls], collocated)
        block.z = Var([own.name for own in (*phase.delayed, *phase.algebraic)], collocated)
        curves = guess.samples(mesh.fractions)
        for state in phase.states:
            if state.name in names:
                data = self._fill(block.x, state.name, points.tolist(), state.bounds, curves[state.name].tolist())
                for k, ends in ((0, state.initial), (self.last, state.final)):
                    if k in data:
                        bound(data[k], ends, data[k].value)
        for variable, (component, name) in zip(phase.inputs, self.inputs, strict=True):
            self._fill(component, name, mesh.collocated.tolist(), variable.bounds, curves[name].tolist())
        self.at_ends = {k: own for k, end in ((0, "initial"), (self.last, "final")) if (own := self._needed(k, end))}
        block.end = Var([(name, k) for k, own in self.at_ends.items() for name in sorted(own.names)])
        for variable in phase.algebraic:
            open_points = [k for k in self.at_ends if (variable.name, k) in block.end]
            self._fill(block.end, variable.name, open_points, variable.bounds, curves[variable.name].tolist())

    def _needed(self, k: int, end: str) -> Determined | None:
        """What has to be determined at an end that is no collocation point."""
        needed = Determined() if k in self.mesh.collocated else needed_at(self.phase, end)
        return needed if needed.names else None

    def _fill(self, component: Var, name: str, points: list[int], bounds: Range, values: list[float]) -> dict:
        """Give one state or input its bounds and initial values; returns the variables by point."""
        lower, upper = finite(bounds.lower), finite(bounds.upper)
        data = {k: component[name, k] for k in points}
        for k, variable in data.items():
            variable.set_value(values[k], skip_validation=True)
            if lower is not None:
                variable.setlb(lower)
            if upper is not None:
                variable.setub(upper)
        return data

    def points(self, name: str, points: np.ndarray) -> Any:
        """The Set of some points; the one of all points, which Pyomo need not store, if they are all."""
        if len(points) == self.last + 1:
            return self.block.point
        self.block.add_component(name, Set(initialize=points.tolist()))
        return self.block.component(name)

    def data(self, name: str, index: Any, values: np.ndarray) -> Param:
        """A Param of the block.

        name: of it.
        index: the Set that it is over; None for 0, 1, 2, ...
        values: (M,), in the order of the Set.
        """
        index = RangeSet(0, len(values) - 1) if index is None else index
        table = dict(zip(index, values.tolist(), strict=True))
        # Given a dict or no domain, Pyomo checks every index or value.
        parameter = Param(index, within=AnyValue, initialize=lambda block, i: table[i])
        self.block.add_component(name, parameter)
        return parameter

    @property
    def inputs(self) -> list[tuple[Var, str]]:
        """(component, name) of each row of u."""
        controls = [(self.block.u, control.name) for control in self.phase.controls]
        return controls + [(self.block.z, own.name) for own in (*self.phase.delayed, *self.phase.algebraic)]

    # -- the values at one point, by the names that the problem's functions use -----------------------------------

    @property
    def duration(self) -> Any:
        return self.block.tF - self.block.t0

    def at(self, k: Any, states: Iterable[str], inputs: bool = True) -> Values:
        """The values at a point by name: p, t, inputs and states.

        k: number of the point, or the placeholder of an index.
        states: names of those that are asked for.
        inputs: whether there are any at this point.
        """
        block = self.block
        makers = {name: (block.x, name) for name in states}
        makers |= {name: (component, name) for component, name in self.inputs if inputs}
        values = Values(makers, k, self._time)
        values.update(self.constants)
        return values

    def _time(self, k: Any) -> Any:
        return self.block.t0 + self.duration * item(self.block.fraction, k)

    def ends(self) -> dict[str, Any]:
        """The values at both ends of the phase, by names such as "q1[final]"."""
        values = dict(self.constants)
        for end, last in (("initial", False), ("final", True)):
            at_end = self.end_values(last)
            values |= {f"{name}[{end}]": at_end[name] for name in at_end.names() if name not in self.constants}
            values[f"t[{end}]"] = self.block.tF if last else self.block.t0
        return values

    # -- constraints and objective ---------------------------------------------------------------------------------

    def constraints(self) -> None:
        self.dynamics()
        for i, residual in enumerate(self.phase.residuals):
            self._everywhere(f"residual{i}", residual, RESIDUAL)
        for i, constraint in enumerate(self.phase.path):
            self._everywhere(f"path{i}", constraint, PATH)
        self._path_at_ends()
        self._bounds_of_computed_states()
        for i, constraint in enumerate(self.phase.boundary):

            def rule(block: Any, *, c: PathConstraint = constraint) -> Any:  # Pyomo takes a positional one for an index
                return between(c.bounds, c.function(self.ends(), pyomo))

            kind = CONDITION if self.phase.static else BOUNDARY
            self.add(f"boundary{i}", None, rule, kind, constraint.name, (0.0, 1.0))
        for i, constraint in enumerate(self.phase.integral):

            def rule(block: Any, *, c: PathConstraint = constraint) -> Any:  # Pyomo takes a positional one for an index
                return between(c.bounds, self.integral(c.function))

            self.add(f"integral{i}", None, rule, INTEGRAL, constraint.name, (0.0, 1.0))

    def add(
        self, component: str, over: Any, rule: Any, kind: ConstraintKind, name: str, span: Any, **told: Any
    ) -> None:
        """Add constraints, and tell what they are.

        component: name in the block.
        over: a Set, with a constraint for each of its elements; None for a single one.
        rule: of Pyomo.
        kind, name, span, told: as of `tell`.
        """
        constraint = Constraint(rule=rule) if over is None else Constraint(over, rule=rule)
        self.block.add_component(component, constraint)
        self.tell(constraint, kind, name, span, **told)

    def tell(
        self,
        constraint: Constraint,
        kind: ConstraintKind,
        name: str,
        span: Any,
        weights: np.ndarray | float = 1.0,
        **told: Any,
    ) -> None:
        """Note what the constraints of a component are.

        constraint: the component.
        kind: of its constraints.
        name: of what holds, in the file.
        span: the normalised times from and to which each holds, numbers or (K,) each.
        weights: (K,) quadrature weights for a phase of duration 1.
        told: the rest, as of a `Family`.
        """
        span = np.atleast_2d(np.transpose(span))
        weights = np.broadcast_to(weights, len(span))
        self.families.append(Family(constraint, self.phase.name, kind, name, span, weights, **told))

    def _everywhere(self, component: str, constraint: PathConstraint, kind: ConstraintKind) -> None:
        """A constraint at every collocation point (paper, 3.3 and 4.3)."""
        for place in self.places():

            def relation(k: Any, place: Place = place) -> Any:
                return between(constraint.bounds, constraint.function(place.values(k), pyomo))

            self._at_place(component, place, relation, kind, constraint.name)

    def _path_at_ends(self) -> None:
        """Path constraints on the states alone, and on what these determine, hold at both ends, also where an end is no
        collocation point."""
        for k, end in ((0, "initial"), (self.last, "final")):
            if k in self.mesh.collocated:
                continue
            for i, own in enumerate(self.phase.path):
                if open_at(self.phase, end, own.function):
                    self._at_end(f"path{i}_{end}", k, own, PATH_END)
            for i, own in enumerate(self.at_ends[k].residuals if k in self.at_ends else ()):
                self._at_end(f"residual{i}_{end}", k, own, RESIDUAL_END)

    def _at_end(self, component: str, k: int, constraint: PathConstraint, kind: ConstraintKind) -> None:
        names = self.at_ends[k].names if k in self.at_ends else ()

        def rule(block: Any) -> Any:
            values = self.end_values(bool(k))
            values["t"] = block.tF if k else block.t0
            values.update({variable.name: 0.0 for variable in self.phase.inputs})  # it does not depend on them
            values.update({name: item(block.end, name, k) for name in names})
            return between(constraint.bounds, constraint.function(values, pyomo))

        self.add(component, None, rule, kind, constraint.name, (float(k > 0), float(k > 0)))

    def _bounds_of_computed_states(self) -> None:
        for place in self.places():
            for state in place.computed:
                if (asked := range_of_state(place.asked, state)) == Range():
                    continue

                def relation(k: Any, place: Place = place, name: str = state.name, asked: Range = asked) -> Any:
                    return between(asked, place.values(k)[name])

                self._at_place(f"bound_{state.name}", place, relation, place.asked, state.name)

    def _at_place(self, component: str, place: Place, relation: Any, kind: ConstraintKind, name: str) -> None:
        times = self.mesh.fractions[place.points]
        rule = (lambda b: relation(None)) if place.over is None else (lambda b, k: relation(k))
        self.add(f"{component}{place.name}", place.over, rule, kind, name, (times, times), weights=place.quadrature)

    def cost(self) -> Any:
        cost = self.phase.mayer(self.ends(), pyomo) if self.phase.mayer else 0.0
        return cost + self.integral(self.phase.lagrange) if self.phase.lagrange else cost

    def integral(self, w: Function) -> Any:
        """The integral of w over the phase by the scheme's own quadrature (paper, 3.1 and 4.1)."""
        total = 0.0
        for place in self.places():
            if place.over is None:
                total += place.weight(None) * w(place.values(None), pyomo)
            else:
                total += sum(place.weight(k) * w(place.values(k), pyomo) for k in place.over)
        return total


def _uses_time(phase: Phase) -> bool:
    """Whether any function of the phase asks for t; if none does, the times of the points are no data of the model."""
    return any("t" in names_asked(function) for function in phase.over_time)
