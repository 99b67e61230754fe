"""Trees as texts of the expression language, for what was made of an expression and stands in no file."""

from __future__ import annotations

from collections.abc import Sequence

from ..expressions.functions import FUNCTIONS
from ..expressions.smooth import SLACK, stand_in
from ..expressions.tree import Lookup, Name, Node, Number, Operation, OperatorChain

_SLACK_OF = {stand_in(row.name, SLACK): row for row in FUNCTIONS.values() if row.in_abs}


def spelled(node: Node) -> str:
    """The text that has this tree, with as many parentheses as it may need.

    node: its root; abs, min and max are as they were, or made of slack variables.

    Raises TypeError for what has no text, as abs, min and max made smooth.
    """
    match node:
        case Number(value=value):
            return f"{value:.0f}" if value.is_integer() and abs(value) < 1e15 else repr(value)
        case Name(name=name, end=end):
            return f"{name}[{end}]" if end else name
        case OperatorChain(first=first, links=links):
            return _inside(first) + "".join(f" {link.symbol} {_inside(link.operand)}" for link in links)
        case Lookup(table=name, operands=operands):
            return _called(name, operands)
        case Operation(symbol=symbol, operands=operands):
            return _applied(symbol, operands)
    raise TypeError(f"{type(node).__name__} is no node of an expression")


def _applied(symbol: str, operands: Sequence[Node]) -> str:
    if symbol == "-":
        return f"-{_inside(operands[0])}"
    if symbol == "**":
        return f"{_inside(operands[0])}**{_inside(operands[1])}"
    if symbol in _SLACK_OF:
        return _of_slack(symbol, list(map(spelled, operands)))
    if symbol not in FUNCTIONS:
        raise TypeError(f"{symbol} has no text")
    return _called(symbol, operands)


def _called(name: str, operands: Sequence[Node]) -> str:
    return f"{name}({', '.join(map(spelled, operands))})"


def _inside(node: Node) -> str:
    """The text of a part, in parentheses unless it binds more than any operator."""
    text = spelled(node)
    plain = isinstance(node, Name | Lookup) or (isinstance(node, Operation) and node.symbol in FUNCTIONS)
    return text if plain or (isinstance(node, Number) and not text.startswith("-")) else f"({text})"


def _of_slack(symbol: str, texts: list[str]) -> str:
    """min or max of n values by the n - 1 slack sums that come after them, as of `FunctionRow.from_abs`."""
    values = texts[: (len(texts) + 1) // 2]
    sign, told = "+" if _SLACK_OF[symbol].in_abs > 0 else "-", values[0]
    for value, total in zip(values[1:], texts[len(values) :], strict=True):
        told = f"({told} + {value} {sign} ({total}))/2"
    return told
