"""The names of a problem: what each one is, the numbers of the parameters, the definitions of the others."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

import numpy as np

from ..expressions.evaluation import Fault
from ..expressions.expression import Expression, fault_with
from ..expressions.tree import Name, Node, Number, count, leaves
from ..quantities import Range
from ..schema.fields import Bounded
from ..schema.spec import Spec
from ..text import shorten
from ..yaml.document import Path, dotted
from ..yaml.locations import Finding
from . import lookups, variables
from .circles import untangle
from .delays import delayed_states
from .given import Given, given
from .occurrences import Use, uses
from .roles import (
    ALGEBRAIC,
    CONTROL,
    DELAYED,
    RATE,
    STATE,
    TABLE,
    VARYING,
)
from .troubles import Troubles
from .variables import DeclaredVariable

MAX_SIZE = 100_000  # nodes of one expression with its definitions written out

# Stands for a value that is mistaken; see `checks.repair`.
UNKNOWN = Expression("?", Name(0, 1, "?", None))

Origin = Callable[[Path], Path]
"""Path of a value in the spec of a phase -> where the file has it."""


def range_of(
    entry: Bounded,
    bind: Callable[[Expression], Expression],
    path: Path = (),
    origin: Origin = tuple,
    unit: str = "",
) -> Range:
    """The range of an entry.

    entry: with lower and upper, and perhaps value or equals.
    bind: gives an expression its numbers.
    path: of the entry; () where it does not matter.
    origin: where the file has it.
    unit: of its numbers.
    """

    def end(key: str) -> float:
        place = dotted(origin((*path, *([] if key == "value" else [key])))) if path else ""
        return given(getattr(entry, key), bind, place, unit)

    key = next((key for key in ("value", "equals") if getattr(entry, key, None)), None)
    if key:
        return Range(*[end(key)] * 2)
    return Range(end("lower") if entry.lower else -np.inf, end("upper") if entry.upper else np.inf)


class Symbols:
    """Names and values of a spec.

    states, controls, algebraic: the variables, see variables.py. roles: name -> "parameter", "expression", "static
    parameter", "table", or one of VARYING. numbers: the values of the parameters. tables: those of data. delayed: the
    states at earlier times, by name. definitions: the expressions that
    others may refer to, each after those that it refers to; `varying` are those that vary in time, `fixed` holds the
    numbers and the values of the expressions of parameters alone. findings: mistakes met on the way; without them, all
    of these are complete. uses: every expression of the spec. origin: where the file has what stands at a path of it.
    """

    def __init__(self, spec: Spec, origin: Origin = tuple):
        self.origin = origin
        self.states, self.controls = variables.states(spec), variables.controls(spec)
        self.algebraic = variables.algebraic(spec)
        groups = {
            "time": () if spec.static else ("t",),
            "parameter": spec.parameters,
            "expression": spec.expressions,
            STATE: [state.name for state in self.states],
            CONTROL: [control.name for control in self.controls],
            ALGEBRAIC: [variable.name for variable in self.algebraic if "[" not in variable.name],
            RATE: [variable.name for variable in self.algebraic],
            "static parameter": spec.optimize,
            TABLE: spec.tables,
            "unknown": UNKNOWN.names,
        }
        self.roles: dict[str, str] = {}
        for role, names in groups.items():
            for name in names:
                self.roles.setdefault(name, role)  # of a name that is declared twice, the first is meant
        self.static = frozenset(spec.optimize)
        self.integrals = frozenset(spec.integrals)
        self.findings: list[Finding] = []
        self.tables = lookups.fitted_tables(spec, self.findings)
        found = "optimize" if spec.static else "controls"
        self._troubles = Troubles(self.roles, self.tables, self.integrals, found)
        self.numbers: dict[str, float] = {}
        self.fixed: dict[str, float] = {}
        self.definitions: dict[str, Expression] = {}
        self.varying: set[str] = set()
        self._wrong: set[Path] = set()
        self.uses = tuple(uses(spec))
        self._check_all_names(use for use in self.uses if use.path[0] == "parameters")
        self._units = {name: p.unit for name, p in spec.parameters.items()}
        self._evaluate_parameters({name: p.value for name, p in spec.parameters.items()})
        own = [use for use in self.uses if use.path[0] != "parameters"]
        names = [state.name for state in self.states]
        self.delayed = delayed_states(own, names, self._known, self.findings)
        self.roles |= dict.fromkeys(self.delayed, DELAYED)
        self._check_all_names(own)
        self._collect_definitions({name: named.value for name, named in spec.expressions.items()})

    @property
    def variables(self) -> tuple[DeclaredVariable, ...]:
        """States, controls and algebraic variables."""
        return (*self.states, *self.controls, *self.algebraic)

    def sound(self, path: Path, expression: Expression) -> bool:
        """Whether the expression refers only to what is known, so that it can be evaluated."""
        return path not in self._wrong and all(
            self.roles[n.name] in (*VARYING, "static parameter") or n.name in self.numbers or n.name in self.definitions
            for n in expression.leaves
        )

    def function(
        self,
        expression: Expression,
        definitions: Mapping[str, Expression] | None = None,
        added: frozenset[str] = frozenset(),
    ) -> Expression:
        """The expression with its parameters and definitions bound: a `problem.Function`.

        expression: of the file, or made from one of its.
        definitions: those that take the place of the file's; None for the file's.
        added: static parameters that the file does not name.
        """
        return expression.bind(
            self.numbers, self.definitions if definitions is None else definitions, self.static | added, self.tables
        )

    def number(self, expression: Expression | None, default: float) -> float:
        """The value of an expression of parameters; `default` if there is none."""
        if expression is None:
            return default
        # Most are plain numbers, and there are hundreds of them in a file.
        return expression.root.value if isinstance(expression.root, Number) else self.function(expression).constant()

    def constant_value(self, root: Node) -> float | None:
        """The value of a tree of parameters alone, None for another."""
        if any(name.name not in self.fixed for name in leaves(root)):
            return None
        return self._of_fixed(Expression("", root)).constant()

    def _known(self, root: Node) -> Given | None:
        """As `constant_value`, a number that knows what it is made of."""
        known = all(name.name in self.fixed for name in leaves(root))
        return given(Expression("", root), self._of_fixed) if known else None

    def varies(self, name: str) -> bool:
        """Whether a name has a value at every time."""
        return name in self.varying or self.roles.get(name) in VARYING

    def is_constant(self, root: Node) -> bool:
        """Whether a tree is made of parameters alone; what is mistaken in it counts as constant."""
        return all(
            self.roles.get(name.name, "unknown") in ("parameter", "unknown")
            or name.name in self.fixed
            or (self.roles[name.name] == "expression" and name.name not in self.definitions)
            for name in leaves(root)
        )

    def range(self, entry: Bounded | None, path: Path = (), unit: str = "") -> Range:
        """The range of an entry.

        entry: with some of lower and upper, or None for no bounds.
        path, unit: as of `range_of`.
        """
        return Range() if entry is None else range_of(entry, self.function, path, self.origin, unit)

    def fault(self, expression: Expression) -> Fault | None:
        """What no variable can mend: a part of the expression that is constant and has no finite value."""
        if isinstance(expression.root, Number):
            return None
        known = self._fixed_in(expression)
        return (
            expression.bind(known, {}, tables=self.tables).fault({}) if self.tables else fault_with(expression, known)
        )

    def _fixed_in(self, expression: Expression) -> dict[str, float]:
        return {n.name: self.fixed[n.name] for n in expression.leaves if n.name in self.fixed}

    def _check_all_names(self, found: Iterable[Use]) -> None:
        for use in found:
            self._check_names(use)

    def _check_names(self, use: Use) -> None:
        seen = set()
        for name in use.expression.leaves:
            trouble = self._troubles.of(name, use.context, use.path)
            if trouble and (name.name, name.end) not in seen:
                self.findings.append(Finding(use.path, *trouble))
                self._wrong.add(use.path)
            seen.add((name.name, name.end))
        if wrong := lookups.misused(use.expression, self.tables):
            self._wrong.add(use.path)
            self.findings += [Finding(use.path, *own) for own in wrong if own]

    def _ordered(self, group: str, expressions: dict[str, Expression]) -> list[str]:
        """The names of a group, each after those that its expression refers to; those in a circle are left out."""
        graph = {name: {n.name for n in e.leaves} & expressions.keys() for name, e in expressions.items()}
        order, circles = untangle(graph)
        for circle in circles:
            what = f"{' -> '.join(circle[:10])} is a circle: each is defined by the next"
            self.findings.append(Finding((group, circle[0]), what, f"give {circle[0]} without the others"))
            self._wrong.update((group, name) for name in circle)
        return order

    def _evaluate_parameters(self, values: dict[str, Expression]) -> None:
        for name in self._ordered("parameters", values):
            if not self.sound(("parameters", name), values[name]):
                continue
            if fault := self.fault(values[name]):
                self.findings.append(no_value(("parameters", name), fault))
            else:
                path = dotted(self.origin(("parameters", name)))
                self.numbers[name] = self.fixed[name] = given(values[name], self._of_fixed, path, self._units[name])

    def _of_fixed(self, expression: Expression) -> Expression:
        return expression.bind(self._fixed_in(expression), {}, tables=self.tables)

    def _collect_definitions(self, expressions: dict[str, Expression]) -> None:
        sizes: dict[str, int] = {}
        for name in self._ordered("expressions", expressions):
            expression = expressions[name]
            if not self.sound(("expressions", name), expression):
                continue
            inner = {n.name for n in expression.leaves}
            sizes[name] = count(expression.root) + sum(sizes.get(n.name, 0) for n in expression.leaves)
            if sizes[name] > MAX_SIZE:
                what = f"written out, this expression has more than {MAX_SIZE} terms"
                self.findings.append(Finding(("expressions", name), what, "refer to fewer expressions in it"))
                return
            if fault := self.fault(expression):
                self.findings.append(no_value(("expressions", name), fault))
                continue
            self.definitions[name] = expression
            if any(n in self.varying or self.roles[n] in VARYING for n in inner):
                self.varying.add(name)
            elif inner <= self.fixed.keys():
                self.fixed[name] = given(expression, self._of_fixed)


def no_value(path: Path, fault: Fault) -> Finding:
    """The finding for an expression of constants without a finite value."""
    known = ", ".join(f"{name} = {value:g}" for name, value in fault.values.items())
    what = f'"{shorten(fault.text)}" {fault.why}' + (f" with {known}" if known else "")
    return Finding(path, what, "change the expression or the parameters in it")
