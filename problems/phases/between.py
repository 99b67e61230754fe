"""Expressions on the ends of several phases: links, and what the top level asks of the whole trajectory.

A name in them is that of a phase, a point, and the name in it: boost.m[final]. A name without a phase is taken at the
initial time of the first phase that has it, or at the final time of the last.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import replace

from ..expressions.expression import Expression
from ..expressions.tree import Link, Name, Node, OperatorChain
from ..language.walk import mapped
from ..names import lookups
from ..names.roles import TABLE
from ..names.symbols import UNKNOWN, Symbols, no_value, range_of
from ..names.troubles import INTEGRAL
from ..quantities import Range
from ..schema.fields import Bounded
from ..text import did_you_mean
from ..yaml.document import Path
from ..yaml.locations import Finding


class Between:
    """The names of all phases.

    phases: name of each phase, in order -> its symbols. shared: the symbols of what the top level declares.
    """

    def __init__(self, phases: Mapping[str, Symbols], shared: Symbols):
        self.phases, self.shared = phases, shared
        self.numbers = dict(shared.numbers)
        self.static = shared.static.union(*(symbols.static for symbols in phases.values()))
        self.definitions: dict[str, Expression] = {}
        for phase, symbols in phases.items():
            self.numbers |= {f"{phase}.{name}": value for name, value in symbols.numbers.items()}
            for name, definition in symbols.definitions.items():
                prefixed = _prefixed(definition.root, phase, self.static)
                self.definitions[f"{phase}.{name}"] = replace(definition, root=prefixed)

    def function(self, expression: Expression) -> Expression:
        """The expression, without mistakes, as a `problem.Function` of the values at the ends of all phases."""
        root = mapped(mapped(expression.root, self._summed), self._resolved)
        shared = self.shared
        return replace(expression, root=root).bind(self.numbers, self.definitions, self.static, shared.tables)

    def findings(self, path: Path, expression: Expression, constant: bool = False) -> Iterator[Finding]:
        """Every mistake in the names of an expression.

        path: where it stands.
        expression: of values at the ends of phases.
        constant: whether it must be known before the solution is, as a bound.
        """
        if _is_mistaken(expression):
            return
        troubles = {}
        for name in expression.leaves:
            if (trouble := self._trouble(name, constant)) is not None:
                troubles[name.name, name.end] = trouble
        yield from (Finding(path, *trouble) for trouble in troubles.values())
        misused = lookups.misused(expression, self.shared.tables)
        yield from (Finding(path, *own) for own in misused if own)
        if not troubles and not misused and (fault := self.function(expression).fault({})):
            yield no_value(path, fault)

    def unsound(self, constant: Expression) -> bool:
        """Whether an expression that should be a constant has mistakes."""
        return _is_mistaken(constant) or any(self.findings((), constant, constant=True))

    def range(self, entry: Bounded, path: Path = ()) -> Range:
        """The range of the bounds of a link, or of a boundary constraint of the top level, at a path of the file."""
        return range_of(entry, self.function, path)

    def _trouble(self, name: Name, constant: bool) -> tuple[str, str] | None:
        """What is wrong with a name, and the remedy."""
        phase, dot, inner = name.name.partition(".")
        if name.name.startswith(INTEGRAL):
            return self._integral_trouble(inner, name, constant)
        if dot and phase not in self.phases:
            remedy = did_you_mean(phase, self.phases, f"the phases are {', '.join(self.phases)}")
            return f'there is no phase "{phase}"', remedy
        if not dot and self.shared.roles.get(name.name) == TABLE:
            return f"{name.name} is a table of data", lookups.as_called(name.name, self.shared.tables)
        if not dot and (name.name in self.shared.numbers or name.name in self.shared.static):
            return _has_one_value(name) if name.end else None
        owners = [phase] if dot else [own for own in self.phases if inner_known(self.phases[own], name.name)]
        if not owners:
            known = [own for symbols in self.phases.values() for own in symbols.roles if "[" not in own]
            return f'unknown name "{name.name}"', did_you_mean(name.name, known, "declare it, in a phase or for all")
        plain = inner if dot else name.name
        return self._trouble_in(owners[0], plain, name, constant)

    def _integral_trouble(self, plain: str, name: Name, constant: bool) -> tuple[str, str] | None:
        known = set().union(*(symbols.integrals for symbols in self.phases.values()))
        if plain not in known:
            return f'there is no integral "{plain}"', did_you_mean(plain, known, "declare it under integrals:")
        if constant:
            what = f"{name.name} is known at the final time, but this value must be known before the solution is"
            return what, "use numbers and parameters here"
        return (f"{name.name} is one number", f"write {name.name}, without [ ]") if name.end else None

    def _trouble_in(self, phase: str, plain: str, name: Name, constant: bool) -> tuple[str, str] | None:
        symbols = self.phases[phase]
        if not inner_known(symbols, plain):
            return f'the phase {phase} has no "{plain}"', did_you_mean(plain, symbols.roles, "name what it has")
        if not symbols.varies(plain):
            return _has_one_value(name) if name.end else None
        if constant:
            remedy = "use numbers and parameters here"
            return f"{name.name} varies in time, but this value must be known before the solution is", remedy
        if not name.end:
            remedy = f"write {name.name}[final] or {name.name}[initial]"
            return f"{name.name} has a value at every time, but this expression is about the ends of phases", remedy
        return None

    def _summed(self, name: Name) -> Node:
        """For the value of an integral the sum of what each phase has of it."""
        if not name.name.startswith(INTEGRAL):
            return name
        plain, span = name.name.removeprefix(INTEGRAL), (name.start, name.stop)
        owners = [phase for phase, symbols in self.phases.items() if plain in symbols.integrals]
        first, *others = (Name(*span, f"{phase}.{plain}", "final") for phase in owners)
        return OperatorChain(*span, first, tuple(Link(*span, "+", other) for other in others)) if others else first

    def _resolved(self, name: Name) -> Name:
        """A name with its phase."""
        if "." in name.name or name.name in self.shared.static:
            return name
        if not name.end and name.name in self.shared.numbers:
            return name
        owners = [phase for phase in self.phases if inner_known(self.phases[phase], name.name)]
        return replace(name, name=f"{owners[-1 if name.end == 'final' else 0]}.{name.name}")


def inner_known(symbols: Symbols, name: str) -> bool:
    """Whether a phase has a name that may stand in a link."""
    return name in symbols.roles and (name in symbols.numbers or name in symbols.definitions or symbols.varies(name))


def _has_one_value(name: Name) -> tuple[str, str]:
    return f"{name.name} is constant and has only one value", f"write {name.name}"


def _prefixed(root: Node, phase: str, static: frozenset[str]) -> Node:
    return mapped(root, lambda name: name if name.name in static else replace(name, name=f"{phase}.{name.name}"))


def _is_mistaken(expression: Expression) -> bool:
    """Whether it stands for one with a mistake, which is told already."""
    return any(name.name == UNKNOWN.text for name in expression.leaves)
