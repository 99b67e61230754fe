"""The names of a problem: what each one is, the numbers of the parameters, the definitions of the others."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from .expressions import Expression, Fault, cycles
from .places import Finding
from .problem import Range
from .spec import Constraint, Spec
from .syntax import nearest, shorten
from .tree import Name, count, leaves
from .yamltext import Path, show

MAX_SIZE = 100_000  # nodes of one expression with its definitions written out

# Stands for a value that is mistaken; see repair.py.
UNKNOWN = Expression("?", Name(0, 1, "?", None))

# Where an expression stands decides what it may refer to.
CONSTANT, TRAJECTORY, BOUNDARY = "constant", "trajectory", "boundary"


class Use(NamedTuple):
    """An expression of the file: its path, and what it may refer to."""

    path: Path
    expression: Expression
    context: str


def uses(spec: Spec) -> Iterator[Use]:
    """Every expression of the file."""
    for name, parameter in spec.parameters.items():
        yield Use(("parameters", name), parameter.value, CONSTANT)
    for name, expression in spec.expressions.items():
        yield Use(("expressions", name), expression, TRAJECTORY)
    for group in ("time", "states", "controls", "optimize"):
        yield from _constants(getattr(spec, group), (group,))
    for name, state in spec.states.items():
        yield Use(("states", name, "rate"), state.rate, TRAJECTORY)
    sense = "minimize" if spec.objective.minimize else "maximize"
    for term, context in (("integral", TRAJECTORY), ("terminal", BOUNDARY)):
        if expression := getattr(spec.objective.terms, term):
            yield Use(("objective", sense, term), expression, context)
    for path, constraint in constraints(spec):
        yield Use((*path, "expression"), constraint.expression, BOUNDARY if path[1] == "boundary" else TRAJECTORY)
        for key in ("lower", "upper", "equals"):
            if bound := getattr(constraint, key):
                yield Use((*path, key), bound, CONSTANT)
    yield from _constants(spec.guess.constants, ("guess", "constants"))
    yield from _constants(spec.guess.keyframes, ("guess", "keyframes"))


def constraints(spec: Spec) -> Iterator[tuple[Path, Constraint]]:
    """Every constraint with its path, such as ("constraints", "path", 0)."""
    for kind in ("path", "boundary", "integral"):
        for i, constraint in enumerate(getattr(spec.constraints, kind)):
            yield ("constraints", kind, i), constraint


def _constants(value, path: Path) -> Iterator[Use]:
    """The expressions below a path, except rates: they are all constants."""
    if isinstance(value, Expression):
        yield Use(path, value, CONSTANT)
    elif isinstance(value, list):
        for i, item in enumerate(value):
            yield from _constants(item, (*path, i))
    elif isinstance(value, dict) or hasattr(type(value), "model_fields"):
        items = value.items() if isinstance(value, dict) else value
        for key, item in items:
            if key != "rate":
                yield from _constants(item, (*path, key))


class Symbols:
    """Names and values of a spec.

    kinds: name -> "parameter", "expression", "state", "control", "static parameter" or "time". numbers: the values
    of the parameters that have one. definitions: the expressions that others may refer to. findings: mistakes met
    on the way; without them, `numbers` and `definitions` are complete.
    """

    def __init__(self, spec: Spec):
        groups = {
            "time": ("t",),
            "parameter": spec.parameters,
            "expression": spec.expressions,
            "state": spec.states,
            "control": spec.controls,
            "static parameter": spec.optimize,
            "unknown": UNKNOWN.names,
        }
        self.kinds = {name: kind for kind, names in groups.items() for name in names}
        self.static = frozenset(spec.optimize)
        self.findings: list[Finding] = []
        self.numbers: dict[str, float] = {}
        self.definitions: dict[str, Expression] = {}
        self._wrong: set[Path] = set()
        for use in uses(spec):
            self._check_names(use)
        self._evaluate_parameters({name: p.value for name, p in spec.parameters.items()})
        self._collect_definitions(spec.expressions)

    def sound(self, path: Path, expression: Expression) -> bool:
        """Whether the expression refers only to what is known, so that it can be evaluated."""
        return path not in self._wrong and all(
            self.kinds[n.name] in ("time", "state", "control", "static parameter")
            or n.name in self.numbers
            or n.name in self.definitions
            for n in leaves(expression.root)
        )

    def function(self, expression: Expression) -> Expression:
        """The expression with its parameters and definitions bound: a `problem.Function`."""
        return expression.bind(self.numbers, self.definitions, self.static)

    def number(self, expression: Expression | None, default: float) -> float:
        """The value of an expression of parameters; `default` if there is none."""
        return default if expression is None else self.function(expression).constant()

    def range(self, entry) -> Range:
        """The range of an entry with lower and upper, and perhaps value or equals."""
        if entry is None:
            return Range()
        value = getattr(entry, "value", None) or getattr(entry, "equals", None)
        lower, upper = (value, value) if value else (entry.lower, entry.upper)
        return Range(self.number(lower, -np.inf), self.number(upper, np.inf))

    def varying(self, name: str) -> bool:
        """Whether a name has a value at every time rather than one value."""
        if self.kinds.get(name) == "expression" and name in self.definitions:
            names = self.function(self.definitions[name]).names
            return any(self.kinds[n] in ("time", "state", "control") for n in names)
        return self.kinds.get(name) in ("time", "state", "control")

    def _check_names(self, use: Use) -> None:
        seen = set()
        for name in leaves(use.expression.root):
            trouble = self._trouble(name, use.context)
            if trouble and (name.name, name.end) not in seen:
                self.findings.append(Finding(use.path, *trouble))
                self._wrong.add(use.path)
            seen.add((name.name, name.end))

    def _trouble(self, name: Name, context: str) -> tuple[str, str] | None:
        kind = self.kinds.get(name.name)
        if kind is None:
            return self._unknown(name.name, context)
        if kind == "unknown":
            return None
        if context == CONSTANT and kind != "parameter":
            return (
                f"{name.name} is a {kind}, but this value must be known before the solution is",
                "use numbers and parameters here, and put conditions on other names under constraints:",
            )
        if context == TRAJECTORY and name.end:
            return (
                f"{name.name}[{name.end}] is a value at one end, but this expression is taken at every time",
                f"write {name.name}, or move the expression to constraints.boundary or to the terminal objective",
            )
        if context == BOUNDARY and name.end and kind in ("parameter", "static parameter"):
            return f"{name.name} is a {kind} and has only one value", f"write {name.name}"
        if context == BOUNDARY and not name.end and kind in ("time", "state", "control"):
            return _bare(name.name, kind)
        return None

    def _unknown(self, name: str, context: str) -> tuple[str, str]:
        what = f'unknown name "{name}"'
        if name == "e":
            return what, "write exp(...) for a power of e"
        known = [n for n, kind in self.kinds.items() if kind == "parameter" or (context != CONSTANT and n != "?")]
        if close := nearest(name, [*known, "pi"]):
            return what, f"did you mean {close}?"
        return what, f"declare it, for example under parameters: as {name}: 1.0"

    def _evaluate_parameters(self, values: dict[str, Expression]) -> None:
        graph = {name: {n.name for n in leaves(v.root)} & values.keys() for name, v in values.items()}
        for cycle in cycles(graph):
            self.findings.append(_circle("parameters", cycle))
            self._wrong.update(("parameters", name) for name in cycle)
        # each round evaluates the parameters whose own parameters are known
        waiting = [name for name in values if ("parameters", name) not in self._wrong]
        while ready := [name for name in waiting if graph[name] <= self.numbers.keys()]:
            for name in ready:
                self._evaluate_parameter(name, values[name])
            waiting = [name for name in waiting if name not in ready]

    def _evaluate_parameter(self, name: str, expression: Expression) -> None:
        if fault := self.function(expression).fault({}):
            self.findings.append(no_value(("parameters", name), fault))
        elif self.sound(("parameters", name), expression):
            self.numbers[name] = self.function(expression).constant()

    def _collect_definitions(self, expressions: dict[str, Expression]) -> None:
        graph = {name: {n.name for n in leaves(e.root)} & expressions.keys() for name, e in expressions.items()}
        for cycle in cycles(graph):
            self.findings.append(_circle("expressions", cycle))
            self._wrong.update(("expressions", name) for name in cycle)
        sizes: dict[str, int] = {}
        waiting = list(expressions)
        while ready := [n for n in waiting if graph[n] <= sizes.keys() and self._usable(n, expressions[n])]:
            for name in ready:
                inner = [n.name for n in leaves(expressions[name].root) if n.name in sizes]
                sizes[name] = count(expressions[name].root) + sum(sizes[n] for n in inner)
                if sizes[name] > MAX_SIZE:
                    what = f"written out, this expression has more than {MAX_SIZE} terms"
                    self.findings.append(Finding(("expressions", name), what, "refer to fewer expressions in it"))
                    return
                self.definitions[name] = expressions[name]
            waiting = [name for name in waiting if name not in ready]

    def _usable(self, name: str, expression: Expression) -> bool:
        parameters = [n.name for n in leaves(expression.root) if self.kinds.get(n.name) == "parameter"]
        known = self.numbers.keys() >= set(parameters) and "?" not in expression.names
        return known and ("expressions", name) not in self._wrong


def no_value(path: Path, fault: Fault) -> Finding:
    """The finding for an expression of constants without a finite value."""
    known = ", ".join(f"{name} = {value:g}" for name, value in fault.values.items())
    what = f'"{shorten(fault.text)}" {fault.why}' + (f" with {known}" if known else "")
    return Finding(path, what, "change the expression or the parameters in it")


def _bare(name: str, kind: str) -> tuple[str, str]:
    what = f"{name} is a {kind}, which has a value at every time, but this expression is about the two ends"
    return what, f"write {name}[final] or {name}[initial]"


def _circle(group: str, cycle: list[str]) -> Finding:
    what = f"{' -> '.join(cycle)} is a circle: each is defined by the next"
    return Finding((group, cycle[0]), what, f"give {show((group, cycle[0]))} without the others")
