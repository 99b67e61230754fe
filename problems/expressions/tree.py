"""The tree of an expression: Python's parser reads the text, a whitelist of its syntax nodes becomes these nodes."""

from __future__ import annotations

import ast
import math
from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from ..lean.records import dataclass
from ..text import excerpt, shorten
from .delays import delayed
from .functions import FUNCTIONS, smooth_names
from .slips import DURATION, ENDS, MAX_PARENTHESES, RATE, check_syntax
from .tokens import ExpressionError


@dataclass(frozen=True)
class Node:
    """A piece of the expression; start and stop are its span in the text."""

    start: int
    stop: int


@dataclass(frozen=True)
class Number(Node):
    value: float


@dataclass(frozen=True)
class Name(Node):
    """A named value; `end` is "initial" or "final" where it is taken at an end of time, else None.

    In a link or in the objective of several phases the name is that of a phase, a point, and the name in it: boost.m.
    The rate of an implicit state is a value with a name of its own, such as "v[rate]", and so is a state at an earlier
    time, "v(t - tau)".
    """

    name: str
    end: str | None


@dataclass(frozen=True)
class Operation(Node):
    """A function of the table `functions.FUNCTIONS`, minus its operand ("-"), or the power of two ("**").

    `nonsmooth.rewrite` replaces abs, min and max by operations of its own, "abs tanh" and the like; see smooth.py.
    """

    symbol: str
    operands: tuple[Node, ...]


@dataclass(frozen=True)
class Lookup(Node):
    """A table of data at its arguments, or a function of the file, which `language.functions` writes out."""

    table: str
    operands: tuple[Node, ...]


@dataclass(frozen=True)
class Link(Node):
    """One operator of a chain and its right operand; the span is that of the chain up to here."""

    symbol: str
    operand: Node


@dataclass(frozen=True)
class OperatorChain(Node):
    """first + second - third ..., from the left: kept flat so that a sum of 1000 terms is not 1000 levels deep."""

    first: Node
    links: tuple[Link, ...]


@dataclass(frozen=True)
class Written(OperatorChain):
    """What a call of a function of the file was written out to: a chain without links; `function` is its key."""

    function: str


def parse_tree(text: str, called: Collection[str] = ()) -> Node:
    """The tree of a tidy text.

    text: the expression.
    called: the names of the tables of data and of the functions of the file.

    Raises ExpressionError: what is wrong, where in the text, and how to mend it.
    """
    check_syntax(text, called)
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        what = f"{excerpt(text, 0, len(text))} cannot be read as an expression"
        raise ExpressionError(what, "write it with names, numbers, + - * / ** and parentheses") from error
    return _with_delays(_node(tree, text, 0), text, called)


def _with_delays(node: Node, text: str, called: Collection[str]) -> Node:
    """The tree with a name for each state that is taken at an earlier time."""
    if isinstance(node, Lookup) and node.table not in called:  # `check_syntax` has looked at the argument
        inside = text[node.start : node.stop].partition("(")[2].rpartition(")")[0]
        return Name(node.start, node.stop, delayed(node.table, inside).name, None)
    parts = below(node)
    new = [_with_delays(part, text, called) for part in parts]
    return node if all(a is b for a, b in zip(new, parts, strict=True)) else rebuilt(node, new)


def rate_of(state: str) -> str:
    """The name of a state's rate: "v[rate]"."""
    return f"{state}[{RATE}]"


def nodes(root: Node) -> Iterator[Node]:
    """Every node of the tree, from the left, each before those below it."""
    yield root
    for node in below(root):
        yield from nodes(node)


def below(node: Node) -> tuple[Node, ...]:
    """The nodes that a node is made of: operands from the left."""
    match node:
        case Operation(operands=operands) | Lookup(operands=operands):
            return operands
        case OperatorChain(first=first, links=links):
            return (first, *(link.operand for link in links))
    return ()


def rebuilt(node: Node, new: Sequence[Node]) -> Node:
    """The same node made of others."""
    match node:
        case Operation() | Lookup():
            return replace(node, operands=tuple(new))
        case OperatorChain(links=links):
            kept = (replace(link, operand=operand) for link, operand in zip(links, new[1:], strict=True))
            return replace(node, first=new[0], links=tuple(kept))
    return node


def placed(node: Node, start: int, stop: int) -> Node:
    """The same tree, all of it at one place of a text.

    node: its root.
    start, stop: the span of that place.
    """
    new = rebuilt(node, [placed(part, start, stop) for part in below(node)])
    if isinstance(new, OperatorChain):
        new = replace(new, links=tuple(replace(link, start=start, stop=stop) for link in new.links))
    return replace(new, start=start, stop=stop)


def leaves(root: Node) -> Iterator[Name]:
    """Every name in the tree, from the left."""
    return (node for node in nodes(root) if isinstance(node, Name))


def skeleton(node: Node) -> Any:
    """What a tree says, wherever it stands: equal for trees that mean the same, hashable."""
    own: tuple[Any, ...] = ()
    match node:
        case Number(value=value):
            own = (value,)
        case Name(name=name, end=end):
            own = (name, end)
        case OperatorChain(links=links):
            own = tuple(link.symbol for link in links)
        case Operation(symbol=name) | Lookup(table=name):
            own = (name,)
    return (type(node), *own, *map(skeleton, below(node)))


def count(root: Node) -> int:
    """Number of nodes: a measure of the size of an expression."""
    return sum(1 for _ in nodes(root))


_SYMBOLS: dict[type[ast.operator], str] = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


class _Span(NamedTuple):
    """Where a piece of the text starts and where it stops."""

    start: int
    stop: int

    @classmethod
    def of(cls, tree: ast.expr) -> _Span:
        assert tree.end_col_offset is not None  # the parser always sets it
        return cls(tree.col_offset, tree.end_col_offset)


def _node(tree: ast.expr, text: str, depth: int) -> Node:
    """A syntax node of Python as one of ours; whatever is not named in these functions is refused."""
    span = _Span.of(tree)
    if depth > MAX_PARENTHESES:
        raise ExpressionError(f"{excerpt(text, *span)} is nested too deeply", "name its parts under expressions:")
    node = _leaf(tree, span) or _operation(tree, span, text, depth + 1)
    if node is None:
        what = f"{excerpt(text, *span)} has no place in an expression"
        raise ExpressionError(what, "use names, numbers, + - * / ** and the functions " + " ".join(smooth_names()))
    return node


def _leaf(tree: ast.expr, span: _Span) -> Node | None:
    match tree:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return Number(*span, float(value))
        case ast.Name(id="pi"):
            return Number(*span, math.pi)
        case ast.Name() | ast.Attribute(value=ast.Name()):
            return Name(*span, _spelled(tree), None)
        case ast.Subscript(value=ast.Name() | ast.Attribute(value=ast.Name()) as name, slice=ast.Name(id=mark)):
            return _marked(name, mark, span)
    return None


def _marked(name: ast.Name | ast.Attribute, mark: str, span: _Span) -> Node | None:
    """A name with what stands in brackets behind it."""
    if mark in ENDS:
        return Name(*span, _spelled(name), mark)
    if mark == DURATION:
        first, last = (Name(*span, _spelled(name), end) for end in ENDS)
        return OperatorChain(*span, last, (Link(*span, "-", first),))
    return Name(*span, rate_of(name.id), None) if mark == RATE and isinstance(name, ast.Name) else None


def _spelled(tree: ast.Name | ast.Attribute) -> str:
    """A name, or that of a phase, a point, and a name in it."""
    if isinstance(tree, ast.Name):
        return tree.id
    assert isinstance(tree.value, ast.Name)
    return f"{tree.value.id}.{tree.attr}"


def _operation(tree: ast.expr, span: _Span, text: str, depth: int) -> Node | None:
    match tree:
        case ast.Call(func=ast.Name(id=name), args=arguments, keywords=[]):
            kind = (
                Operation if name in FUNCTIONS else Lookup
            )  # `check_syntax` lets no other name pass than those of the file
            if kind is Operation:
                _check_arguments(name, arguments, text, span)
            return kind(*span, name, tuple(_node(argument, text, depth) for argument in arguments))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Operation(*span, "-", (_node(operand, text, depth),))
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _node(operand, text, depth)
        case ast.BinOp(op=ast.Pow(), left=left, right=right):
            return Operation(*span, "**", (_node(left, text, depth), _node(right, text, depth)))
        case ast.BinOp(op=operator) if type(operator) in _SYMBOLS:
            return _chain(tree, text, depth)
    return None


def _check_arguments(name: str, given: list[ast.expr], text: str, span: _Span) -> None:
    row = FUNCTIONS[name]
    least, most = row.arguments
    if least <= len(given) <= most:
        return
    if row.width is not None and len(given) == 1:
        operand = shorten(ast.get_source_segment(text, given[0]) or "x", 40)
        other = row.width.formula.format(operand if isinstance(given[0], ast.Name) else f"({operand})")
        remedy = f"write {name}({operand}, eps), where eps is the width of the smooth change, or {other}"
        raise ExpressionError(f"{excerpt(text, *span)}: {name} needs a width, for {row.width.why}", remedy)
    wanted = _WANTED.get((least, most), f"{least} to {most} arguments")
    what = f"{excerpt(text, *span)}: {name} takes {wanted}, not {len(given)}"
    raise ExpressionError(what, f"write {name} with {wanted}")


_WANTED = {(1, 1): "one argument", (2, 2): "two arguments"}


def _chain(tree: ast.expr, text: str, depth: int) -> OperatorChain:
    span, links = _Span.of(tree), []
    while isinstance(tree, ast.BinOp) and type(tree.op) in _SYMBOLS:
        operand = _node(tree.right, text, depth)
        links.append(Link(*_Span.of(tree), _SYMBOLS[type(tree.op)], operand))
        tree = tree.left
    return OperatorChain(*span, _node(tree, text, depth), tuple(reversed(links)))
