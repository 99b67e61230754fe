"""What the schema cannot say: names that fit together, bounds that leave room, values that exist."""

from __future__ import annotations

from math import inf, isfinite

from ..expressions.expression import Expression
from ..language.functions import called_functions
from ..language.integrals import where_written
from ..language.means import place_of_mean
from ..language.plain import in_plain
from ..names.occurrences import BOUNDARY, CONSTANT, constraint_names, constraints, residual_names
from ..names.size import too_large
from ..names.symbols import Symbols, no_value
from ..names.variables import DeclaredState
from ..phases import timeless
from ..phases.order import ALONE
from ..quantities import Range
from ..schema.declarations import TimeEnd
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import OPEN_TIME, Finding
from . import structure
from .complementarity import complementarity_mistakes
from .ends import contradictory_ends, delay_mistakes, idle_histories, impossible_at_ends
from .guesses import guess_mistakes, guess_warnings, unordered, values_of
from .measurements import measurement_mistakes, measurement_warnings
from .names import declared_names, title_troubles
from .odd import odd, unused
from .tables import beyond_tables

NO_STATES = Finding(("states",), "there must be at least 1 here", "add a state, or model: with a chain of links")


def check_phase(spec: Spec, whole: bool = True, phase: str = ALONE) -> tuple[list[Finding], list[Finding]]:
    """Every mistake and every warning that concerns more than one value of a phase.

    spec: of the phase by itself, see `phases.merge`.
    whole: as of `checks.phases.check_spec`.
    phase: its name; of several, none needs an objective.
    """
    if not (spec.states or spec.static):
        return [NO_STATES], []
    called, written = called_functions(spec), spec
    spec, mistaken_calls = in_plain(spec)
    checker = _Checker(spec, phase == ALONE)
    checker.errors += mistaken_calls
    checker.errors += declared_names(spec, checker.symbols)
    checker.constants()
    checker.varying_at_ends()
    if not spec.static:
        checker.time()
    for declared in checker.symbols.variables:
        checker.bounds(declared.path, declared.entry)
    for name, static in spec.optimize.items():
        checker.bounds(("optimize", name), static)
    for state in checker.symbols.states:
        checker.ends(state)
    for path, constraint in constraints(spec):
        checker.bounds(path, constraint)
    checker.constraint_names()
    checker.static_guesses()
    checker.data()
    checker.errors += structure.structure_mistakes(spec, checker.symbols, checker.numbers)
    checker.errors += timeless.timeless_mistakes(spec, checker.numbers)
    checker.errors += delay_mistakes(spec, checker.symbols)
    sound = whole and not checker.errors
    if sound or not spec.nonsmooth:
        checker.errors += structure.scaling_mistakes(spec, checker.symbols)
    if whole and not checker.errors:
        if phase == ALONE:
            checker.objective()
        checker.constant_constraints()
        checker.errors += impossible_at_ends(spec, checker.symbols)
        checker.errors += contradictory_ends(spec, checker.symbols)
        checker.errors += beyond_tables(spec, checker.symbols)
        checker.errors += too_large(checker.symbols)
        checker.warnings += unused(spec, checker.symbols, called)
        checker.warnings += odd(spec, checker.symbols)
        checker.warnings += idle_histories(checker.symbols)
        checker.warnings += structure.structure_warnings(spec, checker.symbols)
    found = (checker.errors, checker.warnings)
    errors, warnings = (
        [f._replace(path=where_written(written, place_of_mean(written, f.path))) for f in own] for own in found
    )
    return errors, warnings


class _Checker:
    """Collects the findings about one spec. A value that is itself mistaken is None, and passes the other checks."""

    def __init__(self, spec: Spec, alone: bool):
        self.spec, self.symbols, self.alone = spec, Symbols(spec), alone
        self.errors: list[Finding] = list(self.symbols.findings)
        self.warnings: list[Finding] = []
        self.numbers: dict[Path, float] = {}

    def error(self, path: Path, what: str, remedy: str) -> None:
        self.errors.append(Finding(path, what, remedy))

    def warn(self, path: Path, what: str, remedy: str) -> None:
        self.warnings.append(Finding(path, what, remedy))

    def constants(self) -> None:
        """Every constant has a finite value, and no expression divides by a constant zero."""
        for path, expression, context in self.symbols.uses:
            if path[0] in ("parameters", "expressions") or not self.symbols.sound(path, expression):
                continue
            if fault := self.symbols.fault(expression):
                self.errors.append(no_value(path, fault))
            elif context == CONSTANT:
                self.numbers[path] = self.symbols.number(expression, inf)

    def varying_at_ends(self) -> None:
        """A named expression that varies in time needs [initial] or [final] at the boundary; a constant one none."""
        for path, expression, context in self.symbols.uses:
            if context != BOUNDARY:
                continue
            for name in expression.leaves:
                if name.name not in self.symbols.definitions:
                    continue
                varies = name.name in self.symbols.varying
                if varies and not name.end:
                    what = f"{name.name} varies in time, but this expression is about the two ends"
                    self.error(path, what, f"write {name.name}[final] or {name.name}[initial]")
                elif name.end and not varies:
                    self.error(path, f"{name.name} is constant and has only one value", f"write {name.name}")

    def bounds(self, path: Path, entry: Bounded) -> None:
        lower, upper = self.number(path, entry.lower, "lower"), self.number(path, entry.upper, "upper")
        if lower is not None and upper is not None and lower > upper:
            self.error((*path, "lower"), f"lower {lower:g} is above upper {upper:g}", "exchange or change them")

    def range(self, path: Path, entry: Bounded | None) -> Range | None:
        """The range of an entry; None where one of its ends is mistaken."""
        if entry is None:
            return Range()
        fixed = getattr(entry, "value", None)
        if fixed is not None:
            value = self.numbers.get((*path, "value"))
            return None if value is None else Range(value, value)
        lower, upper = self.number(path, entry.lower, "lower"), self.number(path, entry.upper, "upper")
        return None if lower is None or upper is None or lower > upper else Range(lower, upper)

    def number(self, path: Path, expression: Expression | None, key: str) -> float | None:
        if expression is None:
            return -inf if key == "lower" else inf
        return self.numbers.get((*path, key))

    def ends(self, state: DeclaredState) -> None:
        """What is asked at the ends of time lies within the bounds of the state."""
        bounds = self.range(state.path, state.entry)
        for end in ("initial", "final"):
            path, entry = (*state.path, end), getattr(state.entry, end)
            if entry is None:
                continue
            self.bounds(path, entry)
            asked = self.range(path, entry)
            if bounds is None or asked is None:
                continue
            common = bounds.intersection(asked)
            if common.lower > common.upper:
                what = f"the {end} value {asked} lies outside the bounds {bounds} of {state.name}"
                self.error(path, what, "change it, or lower: and upper: of the state")

    def time(self) -> None:
        entries = {"initial": self.spec.time.initial, "final": self.spec.time.final}
        for end, entry in entries.items():
            self.bounds(("time", end), entry)
        ranges = {end: self.range(("time", end), entry) for end, entry in entries.items()}
        initial, final = ranges["initial"], ranges["final"]
        if initial and final and final.upper <= initial.lower:
            what = f"the final time {final} is not after the initial time {initial}"
            nothing = not self.alone and final.upper == initial.lower
            remedy = "leave this phase out, with what it says under links:" if nothing else "make the final time larger"
            self.error(("time", "final"), what, remedy)
            return
        first, last = (self.time_guess(end, entries[end], ranges[end]) for end in ("initial", "final"))
        if first is not None and last is not None and first >= last:
            what = f"the guess {last:g} of the final time is not after that of the initial time, {first:g}"
            self.error(("time", "final"), what, "give guess: a larger value")

    def time_guess(self, end: str, entry: TimeEnd, bounds: Range | None) -> float | None:
        if bounds is None:
            return None
        if entry.value is None and entry.guess is None and not (isfinite(bounds.lower) and isfinite(bounds.upper)):
            what = f"the {end} time is free in the open range {bounds}, so it needs a guess"
            remedy = f"add guess: with a likely value, in {self.spec.time.unit}"
            self.errors.append(Finding(("time", end), what, remedy, OPEN_TIME))
            return None
        guess = self.numbers.get(("time", end, "guess"), (bounds.lower + bounds.upper) / 2)
        self.inside(("time", end, "guess"), [guess], bounds)
        return guess

    def inside(self, path: Path, values: list[float], bounds: Range | None) -> None:
        outside = [v for v in values if bounds is not None and not bounds.lower <= v <= bounds.upper]
        if outside:
            what = f"the guess {outside[0]:g} lies outside the bounds {bounds}"
            self.warn(path, what, "choose a guess inside; the solver moves it there first")

    def constraint_names(self) -> None:
        given: set[str] = set()
        paths = [path for path, _ in constraints(self.spec)]
        paths += [("residuals", i) for i in range(len(self.spec.residuals))]
        for path, name in zip(paths, constraint_names(self.spec) + residual_names(self.spec), strict=True):
            self.errors += title_troubles((*path, "name"), name, given)
            given.add(name)
        self.errors += complementarity_mistakes(self.spec, self.symbols, given, self.range)

    def static_guesses(self) -> None:
        for name, static in self.spec.optimize.items():
            guess = self.numbers.get(("optimize", name, "guess"))
            if guess is not None:
                self.inside(("optimize", name, "guess"), [guess], self.range(("optimize", name), static))

    def data(self) -> None:
        """Names, lengths and times of the guess and of measurements; guessed values lie inside the bounds."""
        guess, declared = self.spec.guess, {variable.name: variable for variable in self.symbols.variables}
        times = (
            self.range(("time", "initial"), self.spec.time.initial),
            self.range(("time", "final"), self.spec.time.final),
        )
        self.errors += guess_mistakes(self.spec, self.symbols, times)
        self.errors += measurement_mistakes(self.spec, self.symbols, times, self.alone)
        self.warnings += measurement_warnings(self.spec, self.symbols)
        self.warnings += guess_warnings(guess, list(declared))
        for path, name, values in values_of(guess, self.numbers):
            if path == ("guess", "keyframes", "time"):
                self.errors += unordered(values)
            elif variable := declared.get(name):
                self.inside(path, values, self.range(variable.path, variable.entry))

    def objective(self) -> None:
        """There is an objective, and it depends on something that is to be found."""
        spec, terms = self.spec, self.spec.objective.terms
        if spec.measurements:
            return
        if terms.integral is None and terms.terminal is None:
            remedy = "add integral: or terminal: with an expression"
            self.error(("objective", spec.objective.sense), "the objective is empty", remedy)
            return
        fixed = {f"t[{end}]" for end in ("initial", "final") if getattr(spec.time, end).value is not None}
        for state in self.symbols.states:
            ends = ("initial", "final")
            ranges = {end: self.range((*state.path, end), getattr(state.entry, end)) for end in ends}
            fixed |= {f"{state.name}[{end}]" for end, r in ranges.items() if r and r.fixed}
        functions = [self.symbols.function(e) for e in (terms.integral, terms.terminal) if e]
        free = set().union(*(function.names for function in functions)) - {"t"} - fixed
        free_time = spec.time.initial.value is None or spec.time.final.value is None
        if spec.static and not free and not spec.constraints.boundary:
            what = "there is nothing to find: neither an objective nor a constraint asks anything of the parameters"
            self.error(("optimize",), what, "add objective: {minimize: ...}, or constraints:")
        elif not (free or spec.static) and not (terms.integral and free_time):
            what = "the objective is a constant: everything in it is fixed"
            remedy = "let it depend on a control, a free state, or a free time"
            self.error(("objective", spec.objective.sense), what, remedy)

    def constant_constraints(self) -> None:
        """A residual, and a constraint over time or at the ends, depend on something that is not a constant."""
        for path, constraint in constraints(self.spec):
            if path[1] != "integral" and not self.symbols.function(constraint.expression).names:
                named = f" {constraint.name}" if constraint.name else ""
                what = f"the constraint{named} is on a constant"
                self.error((*path, "expression"), what, "let it depend on t, a state or a control, or remove it")
        for i, residual in enumerate(self.spec.residuals):
            if not self.symbols.function(residual.expression).names:
                what = "the residual is a constant, so it says nothing of the unknowns"
                self.error(("residuals", i, "expression"), what, "write an equation of states, controls or x[rate]")
