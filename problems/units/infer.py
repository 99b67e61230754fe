"""The unit of an expression from those of its names; what does not fit together in it is a finding.

A name without a unit is unknown, and nothing follows from it. A number has no unit of its own and adapts: added to
something it is in that unit. As a factor it is a pure number where it looks like one, as in m*v**2/2 or 4/3*pi*r**3;
any other, as in 9.81*m or 0.005*u**2, may stand for something with a unit, and what it is a factor of is unknown. So
is a number times the time (2*t may be an angle), and what a function takes may have numbers as factors: sin(2*x), and
be the time. A number times a pure number is a number: the 5 of T0 + 5*sin(w*t) is in the unit of T0.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from ..expressions.expression import Expression
from ..expressions.functions import FUNCTIONS, OfUnits
from ..expressions.tree import Lookup, Name, Node, Number, Operation, OperatorChain, Written
from ..text import shorten
from ..yaml.document import Path
from ..yaml.locations import Finding
from .measure import Measure, alike, angle, factor, pure, same

_BOUNDS = ("value", "lower", "upper", "equals", "guess")

LARGEST_FACTOR, PARTS = 10, 4  # a factor that is pure: 2, 0.5, 0.75, ...


class Literal(NamedTuple):
    """What is made of numbers alone. plain: whether as a factor it is a pure number."""

    plain: bool


Value = Measure | Literal | None
"""The unit of a value; None for an unknown one."""


class Tables(NamedTuple):
    """What is known of a table of data: the unit of each argument in order, with its name, and that of its values."""

    arguments: Sequence[tuple[str, Value]]
    value: Value


class Reader:
    """Reads units off expressions.

    names: the unit of a name. tables: those of data. functions: key of each function of the file -> the unit that it is
    said to have. constant: the value of a tree of parameters, None for others and
    for what is not known. fixed: whether a tree is of parameters alone.
    """

    def __init__(
        self,
        names: Callable[[Name], Value],
        tables: Mapping[str, Tables],
        functions: Mapping[str, Value],
        constant: Callable[[Node], float | None],
        fixed: Callable[[Node], bool],
    ):
        self.names, self.tables, self.functions, self.constant, self.fixed = names, tables, functions, constant, fixed
        self.findings: list[Finding] = []

    def read(self, path: Path, expression: Expression) -> Value:
        """The unit of an expression; what is wrong in it is added to the findings, at its path."""
        return _Walk(self, path, expression.text).visit(expression.root)

    def bounds(self, path: Path, entry: object, wanted: Value, of: str) -> None:
        """Whether bounds, end values and guesses of an entry are in the unit of what they are of.

        path: of the entry.
        entry: with some of value, lower, upper, equals and guess.
        wanted: their unit.
        of: the name of what they are of.
        """
        for key in _BOUNDS:
            if isinstance(bound := getattr(entry, key, None), Expression):
                self.agree((*path, key), bound, wanted, f"{of} is")

    def agree(self, path: Path, expression: Expression, wanted: Value, said: str) -> None:
        """Whether an expression is in the unit that something else gives.

        path: of the expression.
        expression: without mistakes.
        wanted: its unit.
        said: what asks for it: "the rate of x is".
        """
        value = self.read(path, expression)
        if isinstance(value, Measure) and isinstance(wanted, Measure) and not same(value, wanted):
            self.clash(path, f"{said} {wanted.told}, and {_quoted(expression.text)} {value.told}", value, wanted)

    def clash(self, path: Path, what: str, given: Measure, wanted: Measure) -> None:
        """Add the finding that something is in one unit, and should be in another.

        path: of what is in the wrong unit.
        what: the sentence.
        given: the unit that it has.
        wanted: the one that it should have.
        """
        self.add(path, what, mended(given, wanted))

    def once(self, path: Path, what: str, remedy: str) -> None:
        """Add a finding, the first one at its path: what a function is wrong with, it is at each of its calls.

        path: of what is wrong.
        what: is wrong.
        remedy: for it.
        """
        if all(own.path != path for own in self.findings):
            self.add(path, what, remedy)

    def add(self, path: Path, what: str, remedy: str) -> None:
        """Add a finding.

        path: of what is wrong.
        what: is wrong.
        remedy: for it.
        """
        self.findings.append(Finding(path, what, remedy))


class _Walk:
    """One expression."""

    def __init__(self, reader: Reader, path: Path, text: str):
        self.reader, self.path, self.text = reader, path, text

    def visit(self, node: Node) -> Value:
        value: Value = None
        match node:
            case Number(value=number):
                small = abs(number) <= LARGEST_FACTOR and (number * PARTS).is_integer()
                value = Literal(small or number == math.pi)
            case Name():
                value = self.reader.names(node)
            case Written():
                value = self.called(node)
            case OperatorChain():
                value = self.chain(node)
            case Operation(symbol="**"):
                value = self.power(node)
            case Operation():
                value = self.function(node)
            case Lookup():
                value = self.look_up(node)
        return value

    def chain(self, node: OperatorChain) -> Value:
        value, left = self.visit(node.first), node.first
        for link in node.links:
            other = self.visit(link.operand)
            if link.symbol in "+-":
                value = self.sum(value, other, left, link.operand)
            else:
                value = _product(value, other, link.symbol == "/")
            left = link
        return value

    def called(self, node: Written) -> Value:
        """The unit that a function of the file is said to have, else the one that follows from its arguments."""
        value, declared = self.visit(node.first), self.reader.functions.get(node.function)
        if not isinstance(declared, Measure):
            return value
        if isinstance(value, Measure) and not same(value, declared):
            what = f"{node.function} is said to be {declared.told}, and {self.quoted(node)} is {value.told}"
            self.reader.once(("expressions", node.function), what, mended(value, declared))
        return declared

    def sum(self, a: Value, b: Value, left: Node, right: Node) -> Value:
        """The unit of two values that are added, subtracted or compared."""
        if isinstance(a, Measure) and isinstance(b, Measure):
            if not same(a, b):
                what = (
                    f"{self.quoted(right)} is {b.told}, and cannot be added to {self.quoted(left)}, which is {a.told}"
                )
                short, long = sorted((left, right), key=lambda own: own.stop - own.start)
                if long.start <= short.start and short.stop <= long.stop:  # in a function that is called there
                    what = f"{self.quoted(long)} adds what is {b.told} to what is {a.told}"
                self.found(what, mended(b, a))
                return None
            return Measure(a.quantity, a.text or b.text, a.numeric or b.numeric, a.clock or b.clock)
        if isinstance(a, Literal) and isinstance(b, Literal):
            return Literal(a.plain and b.plain)
        return a if isinstance(a, Measure) else b if isinstance(b, Measure) else None

    def power(self, node: Operation) -> Value:
        exponent = node.operands[1]
        base, of_exponent = map(self.visit, node.operands)
        if isinstance(of_exponent, Measure) and not of_exponent.pure:
            what = f"{self.quoted(exponent)} is {of_exponent.told}, and an exponent is a pure number"
            self.found(what, f"divide it by something in {of_exponent}")
            return None
        number = self.reader.constant(exponent)
        if not isinstance(base, Measure):
            plain = isinstance(base, Literal) and isinstance(of_exponent, Literal)
            return Literal(plain=False) if plain else None
        if number is not None:
            return base.power(number)
        if base.pure or self.reader.fixed(exponent):
            return None
        what = f"{self.quoted(node)} has no unit: its base is {base.told}, and its exponent varies"
        self.found(what, f"divide the base by something in {base}")
        return None

    def function(self, node: Operation) -> Value:
        values = [self.visit(operand) for operand in node.operands]
        if node.symbol not in FUNCTIONS:  # minus
            return values[0]
        if all(isinstance(value, Literal) for value in values):
            return Literal(all(value.plain for value in values if isinstance(value, Literal)))
        kind = FUNCTIONS[node.symbol].units
        if kind in (OfUnits.NUMBER, OfUnits.ANGLE):
            return self.of_number(node, values[0], kind)
        value = values[0]
        for other, operand in zip(values[1:], node.operands[1:], strict=True):
            value = self.sum(value, other, node.operands[0], operand)
        if not isinstance(value, Measure):
            return None
        makes = {OfUnits.ROOT: lambda: value.power(0.5), OfUnits.RATIO: pure, OfUnits.DIRECTION: angle}
        return makes[kind]() if kind in makes else value

    def of_number(self, node: Operation, value: Value, kind: OfUnits) -> Value:
        if not isinstance(value, Measure):
            return None
        plain = angle() if kind is OfUnits.ANGLE else pure()
        if not (value.numeric or value.clock) and not same(value, plain):
            operand = self.quoted(node.operands[0])
            what = f"{node.symbol} takes a pure number or an angle in rad, and {operand} is {value.told}"
            self.found(what, mended(value, angle()) if value.pure else f"divide it by something in {value}")
        return plain

    def look_up(self, node: Lookup) -> Value:
        values = [self.visit(operand) for operand in node.operands]
        known = self.reader.tables.get(node.table, Tables((), None))
        for (name, wanted), value, operand in zip(known.arguments, values, node.operands, strict=False):
            if isinstance(wanted, Measure) and isinstance(value, Measure) and not same(value, wanted):
                what = f"{name} of the table {node.table} is {wanted.told}, and {self.quoted(operand)} {value.told}"
                self.found(what, mended(value, wanted))
        return known.value

    def quoted(self, node: Node) -> str:
        return _quoted(self.text[node.start : node.stop])

    def found(self, what: str, remedy: str) -> None:
        self.reader.findings.append(Finding(self.path, what, remedy))


def _product(a: Value, b: Value, divide: bool) -> Value:
    if isinstance(a, Measure) and isinstance(b, Measure):
        return a.over(b) if divide else a.times(b)
    if isinstance(a, Literal) and isinstance(b, Literal):
        return Literal(a.plain and b.plain)
    measure, factor = (a, b) if isinstance(a, Measure) else (b, a)
    if not isinstance(measure, Measure) or not isinstance(factor, Literal):
        return None
    if measure.bare:
        return factor
    if not factor.plain or measure.clock:
        return None
    inverted = divide and measure is b
    return Measure((measure.power(-1) if inverted else measure).quantity, numeric=True)


def mended(given: Measure, wanted: Measure) -> str:
    """How to mend what is in one unit, and should be in another."""
    if alike(given, wanted):
        return f"multiply it by a parameter {{{factor(given, wanted)}}}, mend its unit, or write units: off"
    return f"something in {wanted.over(given)} is missing as a factor, or a unit is wrong (units: off for no check)"


def _quoted(text: str) -> str:
    return f'"{shorten(text)}"'
