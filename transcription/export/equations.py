"""The continuous problem as formulas in LaTeX, with the names of its file: what a reader wants to see of it.

`latex` writes the nonlinear program out, point by point. Here stand the equations that the file states, before anything
is discrete: expressions are taken as they were written, so abs is |x| whatever stands in for it in the solve.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

from ...problems.expressions.expression import Expression
from ...problems.expressions.signature import signature
from ...problems.lean.records import dataclass
from ...problems.names import variables
from ...problems.phases.merge import phases_as_written
from ...problems.problem import Problem
from ...problems.schema.spec import Spec
from . import formula as write
from .formula import EQUAL, Binding, Formula, Piece
from .written import FINAL, INITIAL, Notation, Writer

MOST = 300  # equations of one group


@dataclass(frozen=True)
class Equation:
    """One equation. lines: in LaTeX, as many as it takes. words: said in place of what has no formula."""

    lines: tuple[str, ...] = ()
    words: str = ""


@dataclass(frozen=True)
class EquationGroup:
    """Equations of one kind, in the order of the file; left_out: how many more there are."""

    title: str
    equations: tuple[Equation, ...]
    left_out: int = 0


def equations(spec: Spec, problem: Problem) -> list[EquationGroup]:
    """The whole problem, group by group; those of several phases one phase after the other.

    spec: of the file, without mistakes.
    problem: built of it; it has the links between phases.
    """
    phases = phases_as_written(spec)
    writer = Writer(Notation(name for own in phases.values() for name in _names(own)))
    found: dict[str, dict[tuple[Equation, ...], list[str]]] = {}
    for name, own in phases.items():
        for title, rows in _Phase(own, writer).groups():
            stated = tuple(_equation(row) for row in rows if row is not None)
            found.setdefault(title, {}).setdefault(stated, []).append(name)
    groups = [
        _group(title, rows, names, len(phases)) for title, alike in found.items() for rows, names in alike.items()
    ]
    if len(phases) > 1:
        groups.append(_group("Between phases", tuple(map(_equation, _between(spec, problem, writer)))))
    return [group for group in groups if group.equations]


def _names(spec: Spec) -> Iterator[str]:
    """Every name that may stand in the equations of a phase."""
    for group in (spec.parameters, spec.expressions, spec.optimize):
        yield from group
    yield from (variable.name for variable in _declared(spec))


def _declared(spec: Spec) -> tuple[variables.DeclaredVariable, ...]:
    return (*variables.states(spec), *variables.controls(spec), *variables.algebraic(spec))


def _equation(row: Equation | Formula) -> Equation:
    return row if isinstance(row, Equation) else Equation(tuple(write.lines(row)))


def _group(title: str, rows: tuple[Equation, ...], names: Sequence[str] = (), phases: int = 1) -> EquationGroup:
    """names: of the phases that have these equations, of so many phases in all."""
    if phases > 1:
        one = "phase" if len(names) == 1 else "phases"
        title += ", every phase" if len(names) == phases else f", {one} {', '.join(names)}"
    return EquationGroup(title, rows[:MOST], max(len(rows) - MOST, 0))


def _between(spec: Spec, problem: Problem, writer: Writer) -> Iterator[Formula]:
    """The objective at the ends of several phases, and the links."""
    if isinstance(problem.mayer, Expression):
        yield writer(problem.mayer).behind(Piece(rf"\{_sense(spec)}\ ", 4.0))
    for link in problem.links:
        if isinstance(link.function, Expression) and (row := writer.within(writer(link.function), link.bounds)):
            yield row


def _sense(spec: Spec) -> str:
    return "min" if spec.objective.sense == "minimize" else "max"


class _Phase:
    """The equations of one phase."""

    def __init__(self, spec: Spec, writer: Writer) -> None:
        self.spec, self.write = spec, writer
        self.states = variables.states(spec)

    def groups(self) -> Iterator[tuple[str, Iterable[Equation | Formula | None]]]:
        """Title and equations, of every kind there may be."""
        yield "Objective", self.objective()
        yield "Dynamics", self.dynamics()
        yield "where", self.definitions()
        yield "At every time", self.over_time()
        yield "Bounds", self.bounds()
        yield "At the ends", self.ends()
        yield "Over all time", self.integrals()

    def objective(self) -> Iterator[Formula]:
        terms, sense = self.spec.objective.terms, _sense(self.spec)
        parts = []
        if terms.terminal is not None:
            parts.append(self.write(terms.terminal))
        if terms.integral is not None:
            parts.append(self.integral(terms.integral))
        if parts:
            yield write.sum_of(parts).signed().behind(Piece(rf"\{sense}\ ", 4.0))

    def integral(self, expression: Expression) -> Formula:
        inside = self.write(expression).signed().size(Binding.QUOTIENT)
        sign, end = Piece(rf"\int_{{{INITIAL}}}^{{{FINAL}}} ", 3.0), Piece(r"\,\mathrm{d}t", 2.0)
        return Formula(inside.behind(sign).before(end).pieces, Binding.PRODUCT)

    def dynamics(self) -> Iterator[Equation | Formula]:
        for state in self.states:
            if not state.implicit:
                rate = self.write.notation.formula(f"{state.name}[rate]")
                yield write.related(EQUAL, rate, self.write(state.rate))
        for residual in self.spec.residuals:
            yield write.related(EQUAL, self.write(residual.expression), write.tex_number(0.0))

    def definitions(self) -> Iterator[Formula]:
        for name, named in self.spec.expressions.items():
            function = signature(name)
            known = self.write.notation.formula
            left = write.looked_up(function.name, list(map(known, function.arguments))) if function else known(name)
            yield write.related(EQUAL, left, self.write(named.value))

    def over_time(self) -> Iterator[Formula | None]:
        for constraint in self.spec.constraints.path:
            yield self.write.bounded(self.write(constraint.expression), constraint)

    def bounds(self) -> Iterator[Formula | None]:
        for variable in _declared(self.spec):
            yield self.write.bounded(self.write.notation.formula(variable.name), variable.entry)
        for name, static in self.spec.optimize.items():
            yield self.write.bounded(self.write.notation.formula(name), static)

    def ends(self) -> Iterator[Formula | None]:
        for end in ("initial", "final"):
            yield self.write.bounded(self.write.notation.formula("t", end), getattr(self.spec.time, end))
            for state in self.states:
                at_end = self.write.notation.formula(state.name, end)
                yield self.write.bounded(at_end, getattr(state.entry, end))
        for constraint in self.spec.constraints.boundary:
            yield self.write.bounded(self.write(constraint.expression), constraint)

    def integrals(self) -> Iterator[Formula | None]:
        for constraint in self.spec.constraints.integral:
            yield self.write.bounded(self.integral(constraint.expression), constraint)
