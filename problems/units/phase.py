"""The units of one phase: what those of its names are, and whether all that is said of it fits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

from ..expressions.delays import delay_of
from ..expressions.expression import parse
from ..expressions.signature import signature
from ..expressions.tree import rate_of
from ..names.occurrences import constraints
from ..names.symbols import Symbols
from ..names.variables import DeclaredState
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding
from .columns import sum_of_squares
from .infer import Reader, Tables, Value
from .measure import Measure, measure_of, pure


class TermUnit(NamedTuple):
    """A term of the objective and its unit."""

    path: Path
    value: Value


class PhaseUnits:
    """Reads all expressions of a phase.

    findings: what does not fit, as far as it was looked at. unknown: path of each unit that is none -> its text.
    """

    def __init__(self, spec: Spec):
        self.spec, self.symbols = spec, Symbols(spec)
        self.unknown: dict[Path, str] = {}
        self._derived: dict[str, Value] = {}
        self._open: set[str] = set()
        # Discrete time numbers the steps.
        self.time = pure() if spec.discrete else self.unit(("time", "unit"), spec.time.unit)
        tables = {name: self._table(name) for name in spec.tables}
        self.declared = self._declared()
        functions = {key: self.declared[key] for key in spec.expressions if signature(key) and key in self.declared}
        constant, fixed = self.symbols.constant_value, self.symbols.is_constant
        self.reader = Reader(lambda name: self.of(name.name), tables, functions, constant, fixed)

    @property
    def findings(self) -> list[Finding]:
        return self.reader.findings

    def of(self, name: str) -> Value:
        """The unit of a name of the file; of what has none but follows from others, the one that follows."""
        if name == "t":
            return replace(self.time, clock=True) if isinstance(self.time, Measure) else None
        if delay := delay_of(name):
            name = delay.state
        if name in self.declared:
            return self.declared[name]
        if name in self._derived or name in self._open:
            return self._derived.get(name)
        self._open.add(name)
        for section in ("parameters", "expressions"):
            if (entry := getattr(self.spec, section).get(name)) is not None:
                value = self.reader.read((section, name), entry.value)
                self._derived[name] = value if isinstance(value, Measure) else None
        return self._derived.get(name)

    def unit(self, path: Path, text: str) -> Measure | None:
        """What a text at a path means."""
        if not text:
            return None
        measure = measure_of(text)
        if measure is None:
            self.unknown[path] = text
        return measure

    def _table(self, name: str) -> Tables:
        entry = self.spec.tables[name]
        path: Path = ("tables", name)
        axes = [(axis, self.unit((*path, "units", axis), (entry.units or {}).get(axis, ""))) for axis in entry.axes]
        return Tables(axes, self.unit((*path, "unit"), entry.unit))

    def _declared(self) -> dict[str, Value]:
        """The units of all names that have one."""
        spec, units = self.spec, dict[str, Value]()
        for section in ("parameters", "expressions", "optimize"):
            for name, entry in getattr(spec, section).items():
                if entry.unit:
                    units[name] = self.unit((section, name, "unit"), entry.unit)
        for variable in self.symbols.variables:
            if isinstance(variable, DeclaredState) and variable.velocity_of and not variable.entry.unit:
                units[variable.name] = self._per_time(units[variable.velocity_of])
            elif "[" not in variable.name:
                units[variable.name] = self.unit((*variable.path, "unit"), variable.unit)
        units |= {rate_of(s.name): self._per_time(units[s.name]) for s in self.symbols.states if s.implicit}
        return units

    def _per_time(self, value: Value) -> Measure | None:
        return value.over(self.time) if isinstance(value, Measure) and isinstance(self.time, Measure) else None

    def check(self) -> list[TermUnit]:
        """Look at everything that is said. Returns the terms of the objective."""
        for section in ("parameters", "expressions"):
            for name, entry in getattr(self.spec, section).items():
                if name in self.declared:
                    self.reader.agree((section, name), entry.value, self.declared[name], f"{name} is said to be")
                else:
                    self.of(name)
        for state in self.symbols.states:
            self._state(state)
        for variable in (*self.symbols.controls, *self.symbols.algebraic):
            self.reader.bounds(variable.path, variable.entry, self.declared.get(variable.name), variable.name)
        for name, static in self.spec.optimize.items():
            self.reader.bounds(("optimize", name), static, self.declared.get(name), name)
        for end in ("initial", "final"):
            self.reader.bounds(("time", end), getattr(self.spec.time, end), self.time, "time")
        self._constraints()
        self._guess()
        return list(self._objective())

    def _state(self, state: DeclaredState) -> None:
        own = self.declared.get(state.name)
        self.reader.bounds(state.path, state.entry, own, state.name)
        for end in ("initial", "final"):
            self.reader.bounds((*state.path, end), getattr(state.entry, end), own, state.name)
        if state.entry.history is not None:
            self.reader.agree((*state.path, "history"), state.entry.history, own, f"{state.name} is")
        if state.rate is None or state.implicit:
            return
        path = state.rate_path or (*state.path, "velocity")
        if path[-1] == "next":
            self.reader.agree(path, state.rate, own if isinstance(own, Measure) else None, f"{state.name} is")
        else:
            self.reader.agree(path, state.rate, self._per_time(own), f"the rate of {state.name} is")

    def _constraints(self) -> None:
        for own in self.symbols.delayed.values():
            delay = delay_of(own.name)
            assert delay is not None
            self.reader.agree(own.path, parse(delay.lag), self.time, f"what is taken from t in {own.name} is")
        for use in self.symbols.uses:
            if use.path[0] in ("residuals", "complementarity"):
                self.reader.read(use.path, use.expression)
        for path, constraint in constraints(self.spec):
            value = self.reader.read((*path, "expression"), constraint.expression)
            if path[1] == "integral":
                value = self._over_time(value)
            self.reader.bounds(path, constraint, value, "the integral" if path[1] == "integral" else "the expression")

    def _guess(self) -> None:
        guess = self.spec.guess
        for key, given in (("constants", guess.constants), ("formulas", guess.formulas), ("simulate", guess.simulate)):
            for name, value in (given or {}).items():
                self.reader.agree(("guess", key, name), value, self.declared.get(name), f"{name} is")
        for name, row in guess.keyframes.items():
            wanted = self.time if name == "time" else self.declared.get(name)
            for i, value in enumerate(row):
                self.reader.agree(("guess", "keyframes", name, i), value, wanted, f"{name} is")

    def _objective(self) -> Iterator[TermUnit]:
        terms, path = self.spec.objective.terms, ("objective", self.spec.objective.sense)
        if terms.integral is not None:
            value = self.reader.read((*path, "integral"), terms.integral)
            yield TermUnit((*path, "integral"), self._over_time(value))
        if terms.terminal is not None:
            yield TermUnit((*path, "terminal"), self.reader.read((*path, "terminal"), terms.terminal))
        for name, entry in self.spec.measurements.items():
            found = sum_of_squares(name, entry, self.symbols, self.time, self.unit, self.reader)
            yield from (TermUnit(*term) for term in found)

    def _over_time(self, value: Value) -> Measure | None:
        return value.times(self.time) if isinstance(value, Measure) and isinstance(self.time, Measure) else None
