"""Pyomo expressions -> LaTeX, in lines that fit on a page.

A formula is a row of pieces between which a line may be broken: before a plus or minus, a relation, the slash of a
quotient too wide for a fraction, or a factor too wide to stand beside another, never inside a fraction or an exponent.
Parentheses have fixed sizes, since LaTeX's growing ones must stand on one line.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import IntEnum
from typing import Any

from ...problems.expressions.functions import FUNCTIONS
from ...problems.lean.records import dataclass
from ..libraries.pyomo import StreamBasedExpressionVisitor, native_numeric_types, value
from ..libraries.pyomo import numeric_expr as ne
from ..libraries.pyomo import relational_expr as relation
from ..program.templates import TemplateError

LINE = 96.0  # digits of 10 pt that fit between the margins of `latex`
FRACTION = 74.0  # wider quotients are written with a slash
TOGETHER = 30.0  # narrower parentheses are not broken
SUBSCRIPT = 0.8  # the width of its digits, which are smaller
INDENT = 2.0


class Binding(IntEnum):
    """How tightly a formula holds together: one that binds less than its place asks for stands in parentheses."""

    SUM = 0
    QUOTIENT = 1  # with a slash
    PRODUCT = 2
    POWER = 3
    CALL = 4
    ATOM = 5


@dataclass(frozen=True)
class Piece:
    """width: in digits, roughly."""

    text: str
    width: float

    def __add__(self, other: Piece) -> Piece:
        return Piece(self.text + other.text, self.width + other.width)


LEFT, RIGHT = Piece("(", 0.8), Piece(")", 0.8)
TALL_LEFT, TALL_RIGHT = Piece(r"\biggl(", 1.5), Piece(r"\biggr)", 1.5)
PLUS, MINUS, SLASH = Piece("+ ", 2.4), Piece("- ", 2.4), Piece("/ ", 1.0)
COMMA = Piece(r",\ ", 1.0)
BESIDE, TIMES = Piece(r"\,", 0.4), Piece(r"\cdot ", 1.5)
EQUAL, AT_MOST = Piece("= ", 2.7), Piece(r"\leq ", 2.7)


@dataclass(frozen=True)
class Formula:
    """The pieces, or minus the pieces; `binding` is that of the pieces."""

    pieces: tuple[Piece, ...]
    binding: Binding = Binding.ATOM
    negative: bool = False

    @property
    def text(self) -> str:
        return " ".join(piece.text for piece in self.pieces)

    @property
    def width(self) -> float:
        return sum(piece.width for piece in self.pieces)

    @property
    def tall(self) -> bool:
        return any(r"\frac" in piece.text for piece in self.pieces)

    def behind(self, piece: Piece) -> Formula:
        """With something glued to its front."""
        return replace(self, pieces=(piece + self.pieces[0], *self.pieces[1:]))

    def before(self, piece: Piece) -> Formula:
        """With something glued to its end."""
        return replace(self, pieces=(*self.pieces[:-1], self.pieces[-1] + piece))

    def size(self, least: Binding) -> Formula:
        """Without its sign, in parentheses if it binds less than that."""
        if self.binding >= least:
            return replace(self, negative=False)
        left, right = (TALL_LEFT, TALL_RIGHT) if self.tall else (LEFT, RIGHT)
        inside = self.together() if self.width <= TOGETHER else self
        return Formula(inside.behind(left).before(right).pieces)

    def together(self) -> Formula:
        """In one piece."""
        return replace(self, pieces=(Piece(self.text, self.width),))

    def signed(self) -> Formula:
        """With its sign among its pieces."""
        if not self.negative:
            return self
        return replace(self.size(Binding.QUOTIENT).behind(MINUS), binding=Binding.SUM)


def tex_name(symbol: str, *subscripts: str) -> Formula:
    """A variable such as x_{v1,3}; words stand upright."""
    written = ",".join(_word(s) for s in subscripts)
    return Formula((Piece(f"{symbol}_{{{written}}}", 1.2 + SUBSCRIPT * len(",".join(subscripts))),))


def _word(word: str) -> str:
    """A letter and a number stand as they are, other words upright, with their underscores."""
    return word if re.fullmatch(r"[A-Za-z]?\d*", word) else r"\mathrm{" + word.replace("_", r"\_") + "}"


def tex_number(x: float) -> Formula:
    """The shortest decimal that means the same float."""
    mantissa, _, exponent = repr(abs(float(x))).partition("e")
    mantissa = mantissa.removesuffix(".0")
    piece = Piece(mantissa, len(mantissa))
    if not exponent:
        return Formula((piece,), negative=x < 0)
    scale = Piece(f"10^{{{int(exponent)}}}", 2 + SUBSCRIPT * len(exponent))
    return Formula((scale if mantissa == "1" else piece + TIMES + scale,), Binding.PRODUCT, x < 0)


def negation(a: Formula) -> Formula:
    return replace(a, negative=not a.negative)


def sum_of(terms: Sequence[Formula]) -> Formula:
    if len(terms) == 1:
        return terms[0]
    pieces = list(terms[0].signed().pieces)
    for term in map(Formula.signed, terms[1:]):
        signed = term.pieces[0].text.startswith(MINUS.text)
        pieces += term.pieces if signed else term.behind(PLUS).pieces
    return Formula(tuple(pieces), Binding.SUM)


def product(a: Formula, b: Formula) -> Formula:
    negative = a.negative != b.negative
    if a.text == "1":
        return replace(b, negative=negative)
    a, b = a.size(Binding.PRODUCT), b.size(Binding.PRODUCT)
    if a.pieces[-1].width + b.pieces[0].width > LINE - INDENT:
        return Formula((*a.pieces, *b.behind(TIMES).pieces), Binding.PRODUCT, negative)
    glued = a.pieces[-1] + (TIMES if b.text[0].isdigit() else BESIDE) + b.pieces[0]
    return Formula((*a.pieces[:-1], glued, *b.pieces[1:]), Binding.PRODUCT, negative)


def quotient(a: Formula, b: Formula) -> Formula:
    negative, width = a.negative != b.negative, max(a.width, b.width)
    if a.tall or b.tall or width > FRACTION:
        pieces = (*a.size(Binding.PRODUCT).pieces, *b.size(Binding.POWER).behind(SLASH).pieces)
        return Formula(pieces, Binding.QUOTIENT, negative)
    return Formula((Piece(rf"\frac{{{a.text}}}{{{b.text}}}", width + 0.5),), Binding.POWER, negative)


def tex_power(base: Formula, exponent: Formula) -> Formula:
    exponent = exponent.signed()
    raised = Piece(f"^{{{exponent.text}}}", SUBSCRIPT * exponent.width)
    if base.binding is Binding.CALL and not base.negative and exponent.text.isdigit():  # sin^2(x)
        first = base.pieces[0]
        found = re.match(r"\\[a-z]+(\{[a-z]+\})?", first.text)
        command = found[0] if found else ""
        rest = Formula((Piece(first.text.removeprefix(command), first.width), *base.pieces[1:]), Binding.POWER)
        return rest.behind(Piece(command, 0.0) + raised)
    return replace(base.signed().size(Binding.ATOM).before(raised), binding=Binding.POWER)


def call(function: str, a: Formula) -> Formula:
    a = a.signed()
    if function == "sqrt" and not a.tall and a.width <= FRACTION:
        return Formula((Piece(rf"\sqrt{{{a.text}}}", a.width + 2),), Binding.POWER)
    if function == "sqrt":
        return tex_power(a, tex_number(0.5))
    command = Piece(FUNCTIONS[function].latex if function in FUNCTIONS else "\\" + function, len(function))
    return replace(replace(a, binding=Binding.SUM).size(Binding.ATOM).behind(command), binding=Binding.CALL)


def looked_up(table: str, operands: Sequence[Formula]) -> Formula:
    """A table of data at its operands."""
    pieces = [piece for operand in operands for piece in operand.signed().before(COMMA).pieces]
    inside = Formula((*pieces[:-1], replace(pieces[-1], text=pieces[-1].text.removesuffix(COMMA.text))), Binding.SUM)
    return replace(inside.size(Binding.ATOM).behind(Piece(_word(table), len(table))), binding=Binding.CALL)


def related(sign: Piece, *sides: Formula) -> Formula:
    """Sides with an equality or an inequality between them."""
    first, *others = map(Formula.signed, sides)
    pieces = [piece for side in others for piece in side.behind(sign).pieces]
    return Formula((*first.pieces, *pieces), Binding.SUM)


class Printer(StreamBasedExpressionVisitor):  # type: ignore[misc]  # Pyomo has no types
    """Expressions and relations of Pyomo -> formulas. names: id of a variable -> its name."""

    def __init__(self, names: Mapping[int, Formula]) -> None:
        super().__init__()
        self.names = names

    def __call__(self, expression: Any) -> Formula:
        return self.walk_expression(expression)

    def initializeWalker(self, expression: Any) -> Any:  # noqa: N802 (Pyomo's name)
        return self.beforeChild(None, expression, None)

    def beforeChild(self, node: Any, child: Any, index: Any) -> Any:  # noqa: N802 (Pyomo's name)
        """Whether to walk into a part of an expression, and its formula if not; called by Pyomo's walker.

        node: the expression.
        child: the part.
        index: of the part in it.
        """
        if child.__class__ in native_numeric_types:
            return False, tex_number(child)
        if child.is_expression_type():
            return True, None
        return False, self.names[id(child)] if child.is_variable_type() else tex_number(value(child))

    def exitNode(self, node: Any, parts: Any) -> Any:  # noqa: N802 (Pyomo's name)
        for kind, write in _NODES.items():
            if isinstance(node, kind):
                return write(node, parts)  # type: ignore[no-untyped-call]
        raise TemplateError(f"{type(node).__name__} has no formula: {node}")


_NODES = {
    ne.SumExpressionBase: lambda node, parts: sum_of(parts),
    ne.ProductExpression: lambda node, parts: product(*parts),
    ne.DivisionExpression: lambda node, parts: quotient(*parts),
    ne.NegationExpression: lambda node, parts: negation(*parts),
    ne.PowExpression: lambda node, parts: tex_power(*parts),
    ne.UnaryFunctionExpression: lambda node, parts: call(node.getname(), *parts),
    ne.ExternalFunctionExpression: lambda node, parts: looked_up(node.getname(), parts[:-1]),  # of tables only
    relation.EqualityExpression: lambda node, parts: related(EQUAL, *parts),
    relation.InequalityExpression: lambda node, parts: related(AT_MOST, *parts),
    relation.RangedExpression: lambda node, parts: related(AT_MOST, *parts),
}


def lines(formula: Formula) -> list[str]:
    """The formula in lines no wider than LINE, but for pieces that are."""
    rows: list[list[str]] = [[]]
    free = LINE
    for piece in formula.signed().pieces:
        if piece.width > free and rows[-1]:
            rows.append([])
            free = LINE - INDENT
        rows[-1].append(piece.text)
        free -= piece.width
    return [" ".join(row) for row in rows]
