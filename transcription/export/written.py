r"""Names and expressions of a problem file as LaTeX: for readers, before anything is discrete.

q1         q_{1}                    u_max      u_{\text{max}}           theta     \theta
v[rate]    \dot{v}                  x[final]   x(t_F)                   boost.m   m^{(\text{boost})}
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence

from ...problems.expressions.expression import Expression
from ...problems.expressions.functions import FUNCTIONS
from ...problems.expressions.tree import Lookup, Name, Node, Number, Operation, OperatorChain
from ...problems.quantities import Range
from ...problems.schema.declarations import EndValue
from ...problems.schema.fields import Bounded
from . import formula as write
from .formula import AT_MOST, EQUAL, Binding, Formula, Piece

INITIAL, FINAL = "t_{0}", r"t_{\mathrm{F}}"
_GREEK = """
alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi rho sigma tau phi chi psi omega
Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega
"""
GREEK = frozenset(_GREEK.split())
_DOTS = {"dot": r"\dot", "ddot": r"\ddot"}


class Notation:
    """Names -> LaTeX. Two names that would look the same are written letter by letter."""

    def __init__(self, names: Iterable[str]) -> None:
        self.known: dict[str, str] = {}
        drawn: dict[str, str] = {INITIAL: "t[initial]", FINAL: "t[final]"}
        for name in dict.fromkeys(names):
            text = _drawn(name)
            if drawn.setdefault(text, name) != name:
                text = _letters(name)
            self.known[name] = text

    def __call__(self, name: str) -> str:
        """The LaTeX of a name: of a phase's, after a point; of a rate, with a dot."""
        phase, _, own = name.rpartition(".")
        bare = own.removesuffix("[rate]")
        text = self.known.get(bare) or _drawn(bare)
        if bare != own:
            stem, under, rest = text.partition("_{")
            text = rf"\dot{{{stem}}}{under}{rest}"
        return rf"{text}^{{({_letters(phase)})}}" if phase else text

    def formula(self, name: str, end: str | None = None) -> Formula:
        """A name, taken at an end of time or not."""
        text, width = self(name), len(name)
        if end is not None and name == "t":
            text = INITIAL if end == "initial" else FINAL
        elif end is not None:
            text, width = rf"{text}({INITIAL if end == 'initial' else FINAL})", width + 4
        return Formula((Piece(text, float(width)),))


def _letters(word: str) -> str:
    return r"\text{" + word.replace("_", r"\_") + "}"


def _word(word: str) -> str:
    """A part of a name: a letter or number as it is, a Greek letter by its name, else upright letters."""
    if word in GREEK:
        return "\\" + word
    return word if len(word) == 1 or word.isdigit() else _letters(word)


def _drawn(name: str) -> str:
    """A name by itself: its stem, and what follows as subscripts."""
    stem, *rest = [part for part in name.split("_") if part] or [name]
    dots = _DOTS[rest.pop()] if rest and rest[-1] in _DOTS else ""
    numbered = re.fullmatch(r"([^\W\d_]+)(\d+)", stem)
    if numbered and (len(numbered[1]) == 1 or numbered[1] in GREEK):
        stem, rest = numbered[1], [numbered[2], *rest]
    text = rf"{dots}{{{_word(stem)}}}" if dots else _word(stem)
    return rf"{text}_{{{','.join(map(_word, rest))}}}" if rest else text


def _difference(a: Formula, b: Formula) -> Formula:
    return write.sum_of([a, write.negation(b if b.negative else b.size(Binding.QUOTIENT))])


_ARITHMETIC: dict[str, Callable[[Formula, Formula], Formula]] = {
    "+": lambda a, b: write.sum_of([a, b]),
    "-": _difference,
    "*": write.product,
    "/": write.quotient,
    "**": write.tex_power,
}


class Writer:
    """Expressions of a file -> formulas."""

    def __init__(self, notation: Notation) -> None:
        self.notation = notation

    def __call__(self, expression: Expression) -> Formula:
        return self.node(expression.root)

    def node(self, node: Node) -> Formula:
        """The formula of a tree."""
        match node:
            case Number(value=math.pi):
                return Formula((Piece(r"\pi ", 1.0),))
            case Number(value=value):
                return write.tex_number(value)
            case Name(name=name, end=end):
                return self.notation.formula(name, end)
            case OperatorChain(first=first, links=links):
                result = self.node(first)
                for link in links:
                    result = self.applied(link.symbol, [result, self.node(link.operand)])
                return result
            case Operation(symbol=symbol, operands=operands):
                return self.applied(symbol, list(map(self.node, operands)))
            case Lookup(table=name, operands=operands):
                return write.looked_up(name, list(map(self.node, operands)))
        raise TypeError(f"{type(node).__name__} is no node of an expression")

    def applied(self, symbol: str, operands: Sequence[Formula]) -> Formula:
        """An operation on formulas."""
        if symbol == "abs":
            bars = Piece(r"\lvert ", 0.5), Piece(r" \rvert ", 0.5)
            return operands[0].signed().together().behind(bars[0]).before(bars[1])
        if symbol in FUNCTIONS:
            known = FUNCTIONS[symbol].latex and len(operands) == 1
            return write.call(symbol, *operands) if known else write.looked_up(symbol, operands)
        return write.negation(operands[0]) if len(operands) == 1 else _ARITHMETIC[symbol](*operands)

    def bounded(self, middle: Formula, entry: Bounded | EndValue | None) -> Formula | None:
        """lower <= middle <= upper, as the entry says; None if it says nothing."""
        if entry is None:
            return None
        equal = getattr(entry, "value", None) or getattr(entry, "equals", None)
        if equal is not None:
            return write.related(EQUAL, middle, self(equal))
        lower, upper = (None if end is None else self(end) for end in (entry.lower, entry.upper))
        if lower is None and upper is None:
            return None
        return write.related(AT_MOST, *(side for side in (lower, middle, upper) if side is not None))

    def within(self, middle: Formula, bounds: Range) -> Formula | None:
        """The same for a range of numbers."""
        if bounds.fixed:
            return write.related(EQUAL, middle, write.tex_number(bounds.lower))
        ends = [None if math.isinf(end) else write.tex_number(end) for end in (bounds.lower, bounds.upper)]
        sides = [side for side in (ends[0], middle, ends[1]) if side is not None]
        return write.related(AT_MOST, *sides) if len(sides) > 1 else None
