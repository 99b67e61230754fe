"""The tree of an expression: Python's parser reads the text, a whitelist of its syntax nodes becomes these nodes."""

from __future__ import annotations

import ast
import math
from collections.abc import Iterator
from dataclasses import dataclass

from .syntax import ENDS, FUNCTIONS, MAX_DEPTH, ExpressionError, check, excerpt


@dataclass(frozen=True, slots=True)
class Node:
    """A piece of the expression; start and stop are its place in the text."""

    start: int
    stop: int


@dataclass(frozen=True, slots=True)
class Number(Node):
    value: float


@dataclass(frozen=True, slots=True)
class Name(Node):
    """A named value; `end` is "initial" or "final" where it is taken at an end of time, else None."""

    name: str
    end: str | None


@dataclass(frozen=True, slots=True)
class Operation(Node):
    """A function of one operand (a name of FUNCTIONS, or "-"), or the power of two ("**")."""

    symbol: str
    operands: tuple[Node, ...]


@dataclass(frozen=True, slots=True)
class Step(Node):
    """One operator of a chain and its right operand; the place is that of the chain up to here."""

    symbol: str
    operand: Node


@dataclass(frozen=True, slots=True)
class Chain(Node):
    """first + second - third ..., from the left: kept flat so that a sum of 1000 terms is not 1000 levels deep."""

    first: Node
    steps: tuple[Step, ...]


def read(text: str) -> Node:
    """The tree of a tidy text. Raises ExpressionError: what is wrong, where in the text, and how to mend it."""
    check(text)
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, RecursionError, MemoryError) as error:
        what = f"{excerpt(text, 0, len(text))} cannot be read as an expression"
        raise ExpressionError(what, "write it with names, numbers, + - * / ** and parentheses") from error
    return _node(tree, text, 0)


def leaves(root: Node) -> Iterator[Name]:
    """Every name in the tree, from the left."""
    match root:
        case Name():
            yield root
        case Operation(operands=operands):
            for operand in operands:
                yield from leaves(operand)
        case Chain(first=first, steps=steps):
            yield from leaves(first)
            for step in steps:
                yield from leaves(step.operand)


def count(root: Node) -> int:
    """Number of nodes: a measure of the size of an expression."""
    match root:
        case Operation(operands=operands):
            return 1 + sum(map(count, operands))
        case Chain(first=first, steps=steps):
            return count(first) + sum(1 + count(step.operand) for step in steps)
    return 1


_SYMBOLS = {ast.Add: "+", ast.Sub: "-", ast.Mult: "*", ast.Div: "/"}


def _node(tree: ast.AST, text: str, depth: int) -> Node:
    """A syntax node of Python as one of ours; whatever is not named in these functions is refused."""
    place = tree.col_offset, tree.end_col_offset
    if depth > MAX_DEPTH:
        raise ExpressionError(f"{excerpt(text, *place)} is nested too deeply", "name its parts under expressions:")
    node = _leaf(tree, place) or _operation(tree, place, text, depth + 1)
    if node is None:
        what = f"{excerpt(text, *place)} has no place in an expression"
        raise ExpressionError(what, "use names, numbers, + - * / ** and the functions " + " ".join(FUNCTIONS))
    return node


def _leaf(tree: ast.AST, place: tuple[int, int]) -> Node | None:
    match tree:
        case ast.Constant(value=int() | float() as value) if not isinstance(value, bool):
            return Number(*place, float(value))
        case ast.Name(id="pi"):
            return Number(*place, math.pi)
        case ast.Name(id=name):
            return Name(*place, name, None)
        case ast.Subscript(value=ast.Name(id=name), slice=ast.Name(id=end)) if end in ENDS:
            return Name(*place, name, end)
    return None


def _operation(tree: ast.AST, place: tuple[int, int], text: str, depth: int) -> Node | None:
    match tree:
        case ast.Call(func=ast.Name(id=name), args=[argument], keywords=[]) if name in FUNCTIONS:
            return Operation(*place, name, (_node(argument, text, depth),))
        case ast.UnaryOp(op=ast.USub(), operand=operand):
            return Operation(*place, "-", (_node(operand, text, depth),))
        case ast.UnaryOp(op=ast.UAdd(), operand=operand):
            return _node(operand, text, depth)
        case ast.BinOp(op=ast.Pow(), left=left, right=right):
            return Operation(*place, "**", (_node(left, text, depth), _node(right, text, depth)))
        case ast.BinOp(op=ast.Add() | ast.Sub() | ast.Mult() | ast.Div()):
            return _chain(tree, text, depth)
    return None


def _chain(tree: ast.BinOp, text: str, depth: int) -> Chain:
    place, steps = (tree.col_offset, tree.end_col_offset), []
    while isinstance(tree, ast.BinOp) and type(tree.op) in _SYMBOLS:
        operand = _node(tree.right, text, depth)
        steps.append(Step(tree.col_offset, tree.end_col_offset, _SYMBOLS[type(tree.op)], operand))
        tree = tree.left
    return Chain(*place, _node(tree, text, depth), tuple(reversed(steps)))
