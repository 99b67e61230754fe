"""Spec -> Problem: expressions become functions, bounds become numbers, ranges are intersected."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import cached_property, partial

from .conserved.implied import without_implied
from .conserved.invariant import without_invariants
from .expressions.expression import Expression
from .expressions.tree import Link, OperatorChain
from .guess import finished, initial_guess
from .guesses.delayed import with_delayed
from .language.plain import shared_in_plain
from .language.times import TimeParameter, beyond_parameter
from .lean.records import dataclass
from .measured import measurements_of
from .names.delays import DelayedState
from .names.given import given
from .names.occurrences import complementarity_names, constraint_names, constraints, residual_names
from .names.symbols import Origin, Symbols
from .names.variables import DeclaredState, DeclaredVariable
from .names.within import within_tables
from .nonsmooth.rewrite import Consistent, Relation, consistent
from .phases.guess import shared_names, through_phases
from .phases.links import links_of, with_times_in_order
from .phases.merge import home, phase_specs
from .phases.order import before_in_time, own_entries, with_left_out
from .problem import Phase, Problem
from .quantities import Complementarity, Constraint, Delayed, Function, Output, Range, State, Variable
from .schema.fields import Bounded
from .schema.spec import Spec
from .yaml.document import Path


def build(spec: Spec, mesh: int = -1) -> Problem:
    """The continuous problem that a loaded spec states, for one entry of its mesh schedule (the last by default).

    Only a smoothing schedule of `nonsmooth:` makes the problems of the entries differ. Raises
    `guesses.simulated.RunawayError` where the guess cannot be simulated, which `load` has found out.
    """
    builders: dict[str, _Builder] = {}
    shared, _ = shared_in_plain(spec)
    for name, own in phase_specs(spec).items():
        taken = {p.name for builder in builders.values() for p in builder.rewritten.parameters}
        builders[name] = _Builder(own, name, mesh, frozenset(taken), partial(home, spec, name))
    first = next(iter(builders.values()))
    symbols = {name: builder.symbols for name, builder in builders.items()}
    phases = [with_times_in_order(builder.phase()) for builder in builders.values()]
    specs = {name: builder.spec for name, builder in builders.items()}
    links, mayer = links_of(shared, phases, symbols) if own_entries(spec) else ((), None)
    phases = through_phases(shared, specs, symbols, phases, links)
    phases = with_times(phases)
    phases = finished(
        phases, specs, symbols, with_left_out(spec), shared_names(spec) if len(phases) > 1 else frozenset()
    )
    if any(phase.delayed for phase in phases):
        before = before_in_time(spec)
        phases = with_delayed([replace(phase, before=before.get(phase.name, "")) for phase in phases])
    made = [own for builder in builders.values() for own in (*builder.times(), *builder.rewritten.parameters)]
    return Problem(
        name=spec.name,
        sense=1 if spec.objective.sense == "minimize" else -1,
        phases=tuple(phases),
        parameters=(*map(first.static, shared.optimize), *made),
        links=links,
        mayer=mayer,
        numbers=dict(first.symbols.numbers),
        literal=tuple(given(width, first.symbols.function) for width in spec.nonsmooth.widths)
        if spec.nonsmooth
        else (),
    )


def with_times(phases: Sequence[Phase]) -> list[Phase]:
    """The phases, with the guesses of all parameters that are times in the guess of each."""
    times = {name: value for phase in phases for name, value in phase.times_in(phase.guess).items()}
    if not times:
        return list(phases)
    return [replace(p, guess=replace(p.guess, parameters={**p.guess.parameters, **times})) for p in phases]


def build_all(spec: Spec) -> list[Problem]:
    """The problem of every entry of the mesh schedule: the same one where they do not differ."""
    meshes = len(next(iter(phase_specs(spec).values())).mesh)
    if spec.nonsmooth is None or len(spec.nonsmooth.widths) < 2:
        return [build(spec)] * meshes
    return [build(spec, mesh) for mesh in range(meshes)]


@dataclass
class _Builder:
    """Builds one phase from the spec that it has by itself.

    taken: names that its slack parameters must not have. origin: where the file has what is at a path of the spec.
    """

    spec: Spec
    name: str
    mesh: int
    taken: frozenset[str]
    origin: Origin

    def __post_init__(self) -> None:
        self.symbols = Symbols(self.spec, self.origin)
        self.rewritten: Consistent = consistent(self.spec, self.symbols, self.mesh, self.taken)
        self.added = frozenset(p.name for p in self.rewritten.parameters)

    def phase(self) -> Phase:
        spec, symbols, rewritten = self.spec, self.symbols, self.rewritten
        time = spec.time
        times = (
            symbols.range(time.initial, ("time", "initial"), time.unit),
            symbols.range(time.final, ("time", "final"), time.unit),
        )
        if spec.static:
            times = Range(0.0, 0.0), Range(0.0, 0.0)
        states = tuple(map(self.state, symbols.states))
        controls = (*map(self.variable, symbols.controls), *rewritten.controls)
        algebraic = tuple(map(self.variable, symbols.algebraic))
        written, products = self.written_constraints(), list(self.products())
        phase = Phase(
            name=self.name,
            initial_time=times[0],
            final_time=times[1],
            states=states,
            controls=controls,
            algebraic=algebraic,
            delayed=tuple(map(self.delayed, symbols.delayed.values())),
            guess=initial_guess(
                spec,
                symbols,
                states,
                (*controls, *algebraic),
                times=times,
                boundary=written["boundary"],
                slack=rewritten.parameters,
            ),
            residuals=self.residuals(),
            path=(*written["path"], *map(self.slack, rewritten.path), *self.signs(), *products),
            complementarity=tuple(Complementarity(own.name, own.function, own.bounds.upper) for own in products),
            boundary=(
                *written["boundary"],
                *map(self.slack, rewritten.boundary),
                *self.of_times(),
            ),
            integral=tuple(written["integral"]),
            lagrange=self.term("integral"),
            mayer=self.term("terminal"),
            time_unit=spec.time.unit,
            steps=round(times[1].lower - times[0].lower) if spec.discrete else 0,
            outputs=self.outputs(),
            measured=tuple(measurements_of(spec, symbols)),
            time_parameters={name: own.end for name, own in self.time_parameters.items()},
        )
        phase = without_invariants(within_tables(phase))
        # What is held to 1e-6 is an inequality, which the Newton engine does not take.
        return phase if spec.solver.engine == "newton" else without_implied(phase)

    @property
    def time_parameters(self) -> dict[str, TimeParameter]:
        return {name: own for name, own in self.spec.optimize.items() if isinstance(own, TimeParameter)}

    def times(self) -> Iterator[Variable]:
        """The static parameters that are times of this phase."""
        return (Variable(name, own.unit) for name, own in self.time_parameters.items())

    def of_times(self) -> Iterator[Constraint]:
        for name, own in self.time_parameters.items():
            difference = beyond_parameter(name, own.end)
            yield Constraint(difference.text, self.bound(difference), Range(0.0, 0.0))

    def outputs(self) -> dict[str, Output]:
        """The expressions of the file and the outputs of the model that have a value at every time, as written.

        abs, min and max in them are these functions themselves, not what stands for them in the equations.
        """
        written, definitions = self.spec.expressions, self.symbols.definitions
        units = {name: written[name].unit for name in definitions if name in written}
        return {
            name: Output(self.symbols.function(definitions[name]), units.get(name, ""))
            for name in definitions
            if name in self.symbols.varying
        }

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

    def static(self, name: str) -> Variable:
        """A static parameter to optimise."""
        entry = self.spec.optimize[name]
        return Variable(name, entry.unit, self.symbols.range(entry, ("optimize", name), entry.unit))

    def variable(self, declared: DeclaredVariable) -> Variable:
        return Variable(declared.name, declared.unit, self.bounds(declared, declared.entry))

    def bounds(self, declared: DeclaredVariable, entry: Bounded | None, *path: str) -> Range:
        """The range of an entry of a variable, which stands at a path below that of the variable."""
        given = self.symbols.range(entry, (*declared.path, *path), declared.unit)
        return given.intersection(Range(lower=0.0)) if declared.name in self.unsigned else given

    def state(self, state: DeclaredState) -> State:
        bounds = self.bounds(state, state.entry)
        return State(
            name=state.name,
            unit=state.unit,
            bounds=bounds,
            rate=self.rate(state),
            initial=bounds.intersection(self.bounds(state, state.entry.initial, "initial")),
            final=bounds.intersection(self.bounds(state, state.entry.final, "final")),
            velocity_of=state.velocity_of,
        )

    def rate(self, state: DeclaredState) -> Function:
        if state.rate_path[-1:] == ("next",):
            following = self.rewritten.expressions.get(state.rate_path, state.rate)
            return self.bound(following.less(state.name))
        return self.function(state.rate_path, state.rate)

    def delayed(self, own: DelayedState) -> Delayed:
        state = next(state for state in self.symbols.states if state.name == own.state)
        assert state.entry.history is not None  # as checked
        history = self.symbols.function(state.entry.history)
        return Delayed(own.name, state.unit, state=own.state, lag=own.lag, history=history)

    def residuals(self) -> tuple[Constraint, ...]:
        names = residual_names(self.spec)
        return tuple(
            Constraint(name, self.function(("residuals", i, "expression"), residual.expression), Range(0.0, 0.0))
            for i, (residual, name) in enumerate(zip(self.spec.residuals, names, strict=True))
        )

    def written_constraints(self) -> dict[str, list[Constraint]]:
        """The constraints of the file, by kind."""
        written: dict[str, list[Constraint]] = {"path": [], "boundary": [], "integral": []}
        for (path, constraint), name in zip(constraints(self.spec), constraint_names(self.spec), strict=True):
            function = self.function((*path, "expression"), constraint.expression)
            written[str(path[1])].append(Constraint(name, function, self.symbols.range(constraint, path)))
        return written

    def pairs(self) -> Iterator[tuple[str, float, Mapping[str, Expression]]]:
        """Name, what a*b may be, and a and b of each pair, before parameters are bound to them."""
        names = complementarity_names(self.spec)
        for i, (entry, name) in enumerate(zip(self.spec.complementarity, names, strict=True)):
            found = {
                side: self.rewritten.expressions.get(("complementarity", i, side), own) for side, own in entry.sides
            }
            yield name, entry.relax[-1], found

    def products(self) -> Iterator[Constraint]:
        """a*b <= relax of each pair."""
        for name, allowed, pair in self.pairs():
            text = "*".join(f"({own.text})" for own in pair.values())
            both = OperatorChain(0, len(text), pair["a"].root, (Link(0, len(text), "*", pair["b"].root),))
            yield Constraint(name, self.bound(Expression(text, both)), Range(upper=allowed))

    def signs(self) -> Iterator[Constraint]:
        """That a and b of each pair are not negative; a variable that is one of them has a bound, see `bounds`."""
        for name, _, pair in self.pairs():
            for side, own in pair.items():
                if own.text not in self.unsigned:
                    yield Constraint(f"{name} {side}", self.bound(own), Range(lower=0.0))

    @cached_property
    def unsigned(self) -> set[str]:
        """The variables that are a or b of a pair: never negative, so they have a bound in place of a constraint."""
        symbols = self.symbols
        names = {own.name for own in symbols.variables}
        return names & {own.text for entry in self.spec.complementarity for _, own in entry.sides}

    def slack(self, relation: Relation) -> Constraint:
        """A constraint on slack variables, its function completed."""
        return Constraint(relation.name, self.bound(relation.expression), relation.bounds)
