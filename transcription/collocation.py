"""Problem + meshes -> a Pyomo model: one builder for every scheme of the table.

The model holds model.p[name], the static parameters to optimise, and one block for each phase, model.phase[name], with

    t0, tF                        initial and final time, fixed where the problem fixes them
    x[state, point]               states; no variable at the points that a scheme eliminates
    u[control, point]             controls, and z[algebraic, point], at the collocation points
    defect<r>_<state>[segment]    the dynamics: sum_i L[r, i] x_i == h sum_j R[r, j] f_j
    residual<i>[point], path<i>[point], boundary<i>, integral<i>

Every rule is called once, with an index placeholder (see `templates.templated`), so that building the constraints costs
the same for ten segments and for ten thousand. The unknowns z are ordered point by point, (x_0, u_0, x_1, u_1, ...),
times and parameters last: the matrix that IPOPT factorises is banded with a narrow border.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass

import numpy as np
import pyomo.core as pyomo
from pyomo.core import Block, ConcreteModel, Constraint, Objective, Param, RangeSet, Set, Var

from ..problems.errors import Mistake, SpecError
from ..problems.problem import Phase, Problem, Range, State
from .mesh import Mesh
from .templates import templated

MAX_UNKNOWNS = 5_000_000  # some 10 GB of Pyomo variables and matrix factors: refused before any memory is taken


@dataclass(frozen=True)
class Family:
    """The constraints of one Pyomo component, told in the user's terms.

    kind: "defect", "residual", "path", "bound" (of an eliminated state), "boundary" or "integral". name: of the state or the
    constraint. span: (M, 2) normalised times that each constraint covers. weights: (M,) quadrature weights of the
    points of a path constraint, else 1. row: of the scheme's defects, else 0.
    """

    component: Constraint
    phase: str
    kind: str
    name: str
    span: np.ndarray
    weights: np.ndarray
    row: int = 0


@dataclass(frozen=True)
class Layout:
    """Where the unknowns of one phase stand: x (n_x, K), inputs u (n_u, K), t (2,); -1 where there is no unknown."""

    phase: Phase
    mesh: Mesh
    x: np.ndarray
    u: np.ndarray
    t: np.ndarray


@dataclass(frozen=True)
class Transcription:
    """A Pyomo model, its free variables in the order of z, and what stands where."""

    problem: Problem
    model: ConcreteModel
    variables: tuple
    phases: tuple[Layout, ...]
    parameters: np.ndarray
    families: tuple[Family, ...]


def transcribe(problem: Problem, meshes: Sequence[Mesh], guess=None, templates: bool = True) -> Transcription:
    """Transcribe a problem on one mesh for each of its phases.

    guess: one for each phase, with the methods of `problems.problem.Guess`; by default the problem's own.
    templates=False gives an ordinary, expanded Pyomo model, for Pyomo's writers.
    Raises SpecError if the nonlinear program would be too large to hold.
    """
    _check_size(problem, meshes)
    guess = guess or [phase.guess for phase in problem.phases]
    model = ConcreteModel(problem.name)
    if problem.parameters:  # Pyomo's LaTeX printer fails on a component without members
        model.p = Var([p.name for p in problem.parameters])
    for parameter in problem.parameters:
        _bound(model.p[parameter.name], parameter.bounds, guess[0].parameters[parameter.name])
    model.phase = Block([phase.name for phase in problem.phases])
    p = {parameter.name: model.p[parameter.name] for parameter in problem.parameters}
    builders = [
        _PhaseBuilder(model.phase[phase.name], p, phase, mesh)
        for phase, mesh in zip(problem.phases, meshes, strict=True)
    ]
    with templated() if templates else nullcontext():
        for builder, start in zip(builders, guess, strict=True):
            builder.variables(start)
            builder.constraints()
        model.cost = Objective(rule=lambda m: problem.sense * sum(builder.cost() for builder in builders))
    return _lay_out(problem, model, builders)


def _check_size(problem: Problem, meshes: Sequence[Mesh]) -> None:
    unknowns = sum(
        len(mesh.fractions) * (len(phase.states) + len(phase.controls))
        for phase, mesh in zip(problem.phases, meshes, strict=True)
    )
    if unknowns > MAX_UNKNOWNS:
        what = f"{unknowns} unknowns are more than the {MAX_UNKNOWNS} that trajopt takes"
        raise SpecError(Mistake("mesh", what, "use fewer segments"))


def _lay_out(problem: Problem, model: ConcreteModel, builders: Sequence[_PhaseBuilder]) -> Transcription:
    variables, phases = [], []

    def place(component, index=None) -> int:
        if index not in component or component[index].fixed:
            return -1
        variables.append(component[index])
        return len(variables) - 1

    for builder in builders:
        block, phase, mesh = builder.block, builder.phase, builder.mesh
        x = np.full((len(phase.states), len(mesh.fractions)), -1)
        u = np.full((len(phase.inputs), len(mesh.fractions)), -1)
        for k in range(len(mesh.fractions)):
            for i, state in enumerate(phase.states):
                x[i, k] = place(block.x, (state.name, k))
            for i, (component, name) in enumerate(builder.inputs):
                u[i, k] = place(component, (name, k))
        t = np.array([place(block.t0), place(block.tF)])
        phases.append(Layout(phase, mesh, x, u, t))
    parameters = np.array([place(model.p, p.name) for p in problem.parameters], int)
    families = tuple(family for builder in builders for family in builder.families)
    return Transcription(problem, model, tuple(variables), tuple(phases), parameters, families)


class _PhaseBuilder:
    """Fills the block of one phase."""

    def __init__(self, block, p, phase: Phase, mesh: Mesh):
        self.block, self.p, self.phase, self.mesh, self.scheme = block, p, phase, mesh, mesh.scheme
        self.eliminated = dict(self.scheme.eliminated)
        self.families: list[Family] = []

    # -- variables ---------------------------------------------------------------------------------------------

    def variables(self, guess) -> None:
        block, phase, mesh = self.block, self.phase, self.mesh
        for name, bounds, value in (
            ("t0", phase.initial_time, guess.initial_time),
            ("tF", phase.final_time, guess.final_time),
        ):
            block.add_component(name, Var())
            _bound(block.component(name), bounds, value)
            block.component(name).fixed = bounds.fixed
        self._index_sets()
        block.x = Var([state.name for state in phase.states], block.stored)
        block.u = Var([control.name for control in phase.controls], block.collocated)
        if phase.algebraic:
            block.z = Var([algebraic.name for algebraic in phase.algebraic], block.collocated)
        last = len(mesh.fractions) - 1
        for state in phase.states:
            ends = {0: state.initial, last: state.final}
            values = guess.sample(state.name, mesh.fractions).tolist()
            for k in block.stored:
                _bound(block.x[state.name, k], ends.get(k, state.bounds), values[k])
        for variable, (component, name) in zip(phase.inputs, self.inputs, strict=True):
            values = guess.sample(name, mesh.fractions).tolist()
            for k in block.collocated:
                _bound(component[name, k], variable.bounds, values[k])

    @property
    def inputs(self) -> list[tuple[Var, str]]:
        """(component, name) of each row of u."""
        controls = [(self.block.u, control.name) for control in self.phase.controls]
        return controls + [(self.block.z, algebraic.name) for algebraic in self.phase.algebraic]

    def _index_sets(self) -> None:
        block, mesh = self.block, self.mesh
        block.point = RangeSet(0, len(mesh.fractions) - 1)
        block.segment = RangeSet(0, mesh.segments - 1)
        gone = mesh.nodes[:, list(self.eliminated)].ravel()
        block.stored = Set(initialize=np.setdiff1d(mesh.nodes, gone).tolist())
        block.collocated = Set(initialize=np.unique(mesh.collocated).tolist())
        block.explicit = Set(initialize=np.setdiff1d(mesh.collocated, gone).tolist())
        for name, index, values in (
            ("first", block.segment, mesh.first),
            ("width", block.segment, mesh.widths),
            ("fraction", block.point, mesh.fractions),
            ("weight", block.point, mesh.weights),
        ):
            block.add_component(name, Param(index, initialize=dict(enumerate(values.tolist()))))

    # -- the values at one point, by the names that the problem's functions use -----------------------------------

    @property
    def duration(self):
        return self.block.tF - self.block.t0

    def h(self, s):
        return self.duration * self.block.width[s]

    def _at(self, k, states: bool = True) -> dict:
        """t, u, p and (unless they are eliminated there) x at point k."""
        block = self.block
        values = dict(self.p)
        values["t"] = block.t0 + self.duration * block.fraction[k]
        values |= {name: component[name, k] for component, name in self.inputs}
        if states:
            values |= {state.name: block.x[state.name, k] for state in self.phase.states}
        return values

    def _nodes(self, s) -> list[dict]:
        """The values at the nodes of segment s; eliminated states are expressions of the others."""
        block, scheme = self.block, self.scheme
        nodes = [self._at(block.first[s] + i, i not in self.eliminated) for i in range(len(scheme.sigma))]
        for node, row in self.eliminated.items():
            for state in self.phase.states:
                x = [other.get(state.name) for other in nodes]
                f = self._rates(state, nodes, scheme.R[row])
                nodes[node][state.name] = scheme.eliminate(node, row, x, f, self.h(s))
        return nodes

    def _rates(self, state: State, nodes: list[dict], weights: np.ndarray) -> list:
        """f at the collocation nodes whose weight is not zero, None at the others."""
        pairs = zip(self.scheme.collocated, weights, strict=True)
        return [state.rate(nodes[i], pyomo) if weight else None for i, weight in pairs]

    def _ends(self) -> dict:
        """The values at both ends of the phase, by names such as "q1[final]"."""
        block = self.block
        values = dict(self.p)
        for end, time, k in (("initial", block.t0, 0), ("final", block.tF, len(self.mesh.fractions) - 1)):
            values[f"t[{end}]"] = time
            values |= {f"{state.name}[{end}]": block.x[state.name, k] for state in self.phase.states}
            values |= {f"{name}[{end}]": component[name, k] for component, name in self.inputs}
        return values

    # -- constraints and objective ---------------------------------------------------------------------------------

    def constraints(self) -> None:
        segments = self.mesh.edges[:-1], self.mesh.edges[1:]
        for state in self.phase.states:
            for r in self.scheme.rows:

                def rule(block, s, r=r, state=state):
                    return self._defect(s, r, state)

                self._add(f"defect{r}_{state.name}", self.block.segment, rule, "defect", state.name, segments, row=r)
        for i, residual in enumerate(self.phase.residuals):
            self._everywhere(f"residual{i}", residual.function, residual.bounds, "residual", residual.name)
        for i, constraint in enumerate(self.phase.path):
            self._everywhere(f"path{i}", constraint.function, constraint.bounds, "path", constraint.name)
        for state in self.phase.states:
            if self.eliminated and state.bounds != Range():

                def own(values, functions, name=state.name):
                    return values[name]

                self._at_eliminated(f"bound_{state.name}", own, state.bounds, "bound", state.name)
        for i, constraint in enumerate(self.phase.boundary):

            def rule(block, constraint=constraint):
                return _between(constraint.bounds, constraint.function(self._ends(), pyomo))

            self._add(f"boundary{i}", None, rule, "boundary", constraint.name, (0.0, 1.0))
        for i, constraint in enumerate(self.phase.integral):

            def rule(block, constraint=constraint):
                return _between(constraint.bounds, self.integral(constraint.function))

            self._add(f"integral{i}", None, rule, "integral", constraint.name, (0.0, 1.0))

    def _add(self, component: str, index, rule, kind: str, name: str, span, weights=1.0, row: int = 0) -> None:
        constraint = Constraint(rule=rule) if index is None else Constraint(index, rule=rule)
        self.block.add_component(component, constraint)
        span = np.atleast_2d(np.transpose(span))
        weights = np.broadcast_to(weights, len(span))
        self.families.append(Family(constraint, self.phase.name, kind, name, span, weights, row))

    def _defect(self, s, r: int, state: State):
        nodes = self._nodes(s)
        x = [node[state.name] for node in nodes]
        f = self._rates(state, nodes, self.scheme.R[r])
        return _dot(self.scheme.L[r], x) == self.h(s) * _dot(self.scheme.R[r], f)  # (3.3), (4.3), (4.4)

    def _everywhere(self, component: str, function, bounds: Range, kind: str, name: str) -> None:
        """A constraint at every collocation point (paper, 3.3 and 4.3)."""
        points = list(self.block.explicit)
        times, weights = self.mesh.fractions[points], self.mesh.weights[points]

        def rule(block, k):
            return _between(bounds, function(self._at(k), pyomo))

        self._add(component, self.block.explicit, rule, kind, name, (times, times), weights)
        self._at_eliminated(f"{component}_eliminated", function, bounds, kind, name)

    def _at_eliminated(self, component: str, function, bounds: Range, kind: str, name: str) -> None:
        for node in self.eliminated:
            points = self.mesh.nodes[:, node]
            times, weights = self.mesh.fractions[points], self.mesh.weights[points]

            def rule(block, s, node=node):
                return _between(bounds, function(self._nodes(s)[node], pyomo))

            self._add(f"{component}{node}", self.block.segment, rule, kind, name, (times, times), weights)

    def cost(self):
        cost = self.phase.mayer(self._ends(), pyomo) if self.phase.mayer else 0.0
        return cost + self.integral(self.phase.lagrange) if self.phase.lagrange else cost

    def integral(self, w):
        """The integral of w over the phase by the scheme's own quadrature (paper, 3.1 and 4.1)."""
        block, b = self.block, dict(zip(self.scheme.collocated, self.scheme.b.tolist(), strict=True))
        total = sum(self.duration * block.weight[k] * w(self._at(k), pyomo) for k in block.explicit)
        for node in self.eliminated:
            total += sum(self.h(s) * b[node] * w(self._nodes(s)[node], pyomo) for s in block.segment)
        return total


def _bound(variable, bounds: Range, value: float) -> None:
    variable.setlb(bounds.lower if np.isfinite(bounds.lower) else None)
    variable.setub(bounds.upper if np.isfinite(bounds.upper) else None)
    variable.set_value(value, skip_validation=True)


def _between(bounds: Range, body):
    if bounds.fixed:
        return body == bounds.lower
    lower = bounds.lower if np.isfinite(bounds.lower) else None
    upper = bounds.upper if np.isfinite(bounds.upper) else None
    return (lower, body, upper)


def _dot(weights: np.ndarray, values: Sequence):
    """sum_i weights[i] * values[i], with no term where the weight is zero."""
    return sum(value if w == 1 else float(w) * value for w, value in zip(weights, values, strict=True) if w)
