"""Spec -> Problem: expressions become functions, bounds become numbers, ranges are intersected."""

from __future__ import annotations

from dataclasses import dataclass

from .expressions.expression import Expression
from .guess import initial_guess
from .names.occurrences import constraint_names, constraints, residual_names
from .names.symbols import Symbols
from .names.variables import Declared, DeclaredState
from .names.within import within_tables
from .nonsmooth.rewrite import Consistent, Relation, consistent
from .problem import Constraint, Function, Phase, Problem, Range, State, Variable
from .schema.spec import Spec
from .yaml.document import Path


def build(spec: Spec, mesh: int = -1) -> Problem:
    """The continuous problem that a loaded spec states, for one entry of its mesh schedule (the last by default).

    Only a smoothing schedule of `nonsmooth:` makes the problems of the entries differ.
    """
    return _Builder(spec, mesh).problem()


def build_all(spec: Spec) -> list[Problem]:
    """The problem of every entry of the mesh schedule: the same one where they do not differ."""
    if spec.nonsmooth is None or len(spec.nonsmooth.widths) < 2:
        return [build(spec)] * len(spec.mesh)
    return [build(spec, mesh) for mesh in range(len(spec.mesh))]


@dataclass
class _Builder:
    spec: Spec
    mesh: int

    def __post_init__(self) -> None:
        self.symbols = Symbols(self.spec)
        self.rewritten: Consistent = consistent(self.spec, self.symbols, self.mesh)
        self.added = frozenset(p.name for p in self.rewritten.parameters)

    def problem(self) -> Problem:
        statics = (Variable(name, p.unit, self.symbols.range(p)) for name, p in self.spec.optimize.items())
        return Problem(
            name=self.spec.name,
            sense=1 if self.spec.objective.sense == "minimize" else -1,
            phases=(self.phase(),),
            parameters=(*statics, *self.rewritten.parameters),
        )

    def phase(self) -> Phase:
        spec, symbols, rewritten = self.spec, self.symbols, self.rewritten
        times = symbols.range(spec.time.initial), symbols.range(spec.time.final)
        states = tuple(map(self.state, symbols.states))
        controls = (*map(self.variable, symbols.controls), *rewritten.controls)
        algebraic = tuple(map(self.variable, symbols.algebraic))
        written = self.written_constraints()
        phase = Phase(
            name="main",
            initial_time=times[0],
            final_time=times[1],
            states=states,
            controls=controls,
            algebraic=algebraic,
            guess=initial_guess(
                spec, symbols, states, (*controls, *algebraic), times=times, slack=rewritten.parameters
            ),
            residuals=self.residuals(),
            path=(*self.of_model("path"), *written["path"], *map(self.slack, rewritten.path)),
            boundary=(*self.of_model("boundary"), *written["boundary"], *map(self.slack, rewritten.boundary)),
            integral=tuple(written["integral"]),
            lagrange=self.term("integral"),
            mayer=self.term("terminal"),
            time_unit=spec.time.unit,
            outputs=self.outputs(),
        )
        return within_tables(phase)

    def outputs(self) -> dict[str, Function]:
        """The expressions of the file and the outputs of the model that have a value at every time, as written.

        abs, min and max in them are these functions themselves, not what stands for them in the equations.
        """
        definitions = self.symbols.definitions
        return {name: self.symbols.function(definitions[name]) for name in definitions if name in self.symbols.varying}

    def term(self, name: str) -> Expression | None:
        """A term of the objective: "integral" or "terminal"."""
        objective = self.spec.objective
        expression = getattr(objective.terms, name)
        return None if expression is None else self.function(("objective", objective.sense, name), expression)

    def function(self, path: Path, expression: Expression) -> Expression:
        """The function for an expression of the file: its stand-in, with parameters and definitions bound."""
        return self.bound(self.rewritten.expressions.get(path, expression))

    def bound(self, expression: Expression) -> Expression:
        return self.symbols.function(expression, self.rewritten.definitions, self.added)

    def variable(self, declared: Declared) -> Variable:
        return Variable(declared.name, declared.unit, self.symbols.range(declared.entry))

    def state(self, state: DeclaredState) -> State:
        bounds = self.symbols.range(state.entry)
        return State(
            name=state.name,
            unit=state.unit,
            bounds=bounds,
            rate=self.rate(state),
            initial=bounds.intersection(self.symbols.range(state.entry.initial)),
            final=bounds.intersection(self.symbols.range(state.entry.final)),
            velocity_of=state.velocity_of,
        )

    def rate(self, state: DeclaredState) -> Function:
        equations = self.symbols.equations
        if state.rate is None:
            assert equations is not None  # a state without an expression for its rate is a model's
            return equations.rates[state.name]
        return self.function(state.rate_path, state.rate)

    def residuals(self) -> tuple[Constraint, ...]:
        names = residual_names(self.spec)
        own = (
            Constraint(name, self.function(("residuals", i, "expression"), residual.expression), Range(0.0, 0.0))
            for i, (residual, name) in enumerate(zip(self.spec.residuals, names, strict=True))
        )
        equations = self.symbols.equations
        model = (Constraint(n, f, Range(0.0, 0.0)) for n, f in equations.residuals.items()) if equations else ()
        return (*model, *own)

    def of_model(self, kind: str) -> tuple[Constraint, ...]:
        """The path or the boundary constraints of the model."""
        equations = self.symbols.equations
        given = getattr(equations, kind) if equations else {}
        return tuple(Constraint(name, function, bounds) for name, (function, bounds) in given.items())

    def written_constraints(self) -> dict[str, list[Constraint]]:
        """The constraints of the file, by kind."""
        written: dict[str, list[Constraint]] = {"path": [], "boundary": [], "integral": []}
        for (path, constraint), name in zip(constraints(self.spec), constraint_names(self.spec), strict=True):
            function = self.function((*path, "expression"), constraint.expression)
            written[str(path[1])].append(Constraint(name, function, self.symbols.range(constraint)))
        return written

    def slack(self, relation: Relation) -> Constraint:
        """A constraint on slack variables, its function completed."""
        return Constraint(relation.name, self.bound(relation.expression), relation.bounds)
