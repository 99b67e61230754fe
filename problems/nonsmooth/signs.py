"""Signs of expressions and of their slopes: which way the value of a part moves the whole.

A set of signs holds +1 if a value may be positive and -1 if it may be negative; zero is in either. The empty set stands
for what has no effect. Signs come from constants and from the bounds of the variables. They also hold where abs and max
are larger than they should be and min is smaller, for slack variables let them be so.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from ..expressions.functions import EITHER, FUNCTIONS, NEGATIVE, POSITIVE, Signs
from ..expressions.tree import Name, Node, Operation, OperatorChain, below
from ..quantities import Range


def product_of_signs(a: Signs, b: Signs) -> Signs:
    return frozenset(x * y for x in a for y in b)


def negative(a: Signs) -> Signs:
    return frozenset(-x for x in a)


def within(bounds: Range) -> Signs:
    """The signs of the values in a range."""
    if bounds.lower >= 0:
        return POSITIVE
    return NEGATIVE if bounds.upper <= 0 else EITHER


class Monotone:
    """ranges: name -> range of its values, at every time and at both ends. constant: a tree -> its number, or None.

    definitions: name -> the tree that the name stands for.
    """

    def __init__(
        self, ranges: Mapping[str, Range], constant: Callable[[Node], float | None], definitions: Mapping[str, Node]
    ):
        self.ranges, self.constant, self.definitions = ranges, constant, definitions
        self._known: dict[str, Signs] = {}

    def signs(self, node: Node) -> Signs:
        """The signs that the value of a tree may have."""
        number = self.constant(node)
        if number is not None:
            return POSITIVE if number >= 0 else NEGATIVE
        match node:
            case Name(name=name):
                return self._of_name(name)
            case Operation(symbol=symbol, operands=operands):
                return self._of_operation(symbol, operands)
            case OperatorChain():
                return self._partial(node)[-1]
        return EITHER

    def slopes(self, node: Node) -> list[Signs]:
        """The signs of the slope of a node's value by each of the nodes below it."""
        match node:
            case OperatorChain():
                return self._slopes_of_chain(node)
            case Operation(symbol="**", operands=(base, exponent)):
                return self._slopes_of_power(base, exponent)
            case Operation(symbol="-"):
                return [NEGATIVE]
            case Operation(symbol=symbol, operands=operands):
                return FUNCTIONS[symbol].slopes([self.signs(operand) for operand in operands])
        return [EITHER] * len(below(node))

    def _of_name(self, name: str) -> Signs:
        if name not in self.definitions:
            return within(self.ranges.get(name, Range()))
        if name not in self._known:
            self._known[name] = self.signs(self.definitions[name])
        return self._known[name]

    def _of_operation(self, symbol: str, operands: tuple[Node, ...]) -> Signs:
        if symbol == "**":
            return self._of_power(*operands)
        found = [self.signs(operand) for operand in operands]
        return negative(found[0]) if symbol == "-" else FUNCTIONS[symbol].sign(found)

    def _of_power(self, base: Node, exponent: Node) -> Signs:
        n = self.constant(exponent)
        if n is None or n % 2 != 1:  # a power that is no whole number has a positive base, an even one hides its sign
            return POSITIVE
        return self.signs(base)

    def _partial(self, chain: OperatorChain) -> list[Signs]:
        """The signs of first, of first + second, and so on."""
        found = [self.signs(chain.first)]
        for link in chain.links:
            operand = self.signs(link.operand)
            if link.symbol in "*/":
                found.append(product_of_signs(found[-1], operand))
            else:
                found.append(found[-1] | (operand if link.symbol == "+" else negative(operand)))
        return found

    def _slopes_of_chain(self, chain: OperatorChain) -> list[Signs]:
        # From the last link, so that `above`, the slope of the whole by all that stands left of a link, is known at it.
        slopes, above = [], POSITIVE
        for link, left in zip(reversed(chain.links), reversed(self._partial(chain)[:-1]), strict=True):
            operand = self.signs(link.operand)
            match link.symbol:
                case "+":
                    by_operand = POSITIVE
                case "-":
                    by_operand = NEGATIVE
                case "*":
                    by_operand = left
                case _:  # a quotient falls as its divisor grows, but for the jump at a divisor of zero
                    by_operand = negative(left) if operand != EITHER else EITHER
            slopes.append(product_of_signs(above, by_operand))
            above = product_of_signs(above, operand) if link.symbol in "*/" else above
        return [above, *reversed(slopes)]

    def _slopes_of_power(self, base: Node, exponent: Node) -> list[Signs]:
        n, b = self.constant(exponent), self.constant(base)
        signs = self.signs(base)
        by_base = EITHER
        if n is None and signs == POSITIVE:
            by_base = self.signs(exponent)
        elif n is not None and (n >= 0 or signs != EITHER):  # a negative power has a pole at zero
            by_base = product_of_signs(POSITIVE if n >= 0 else NEGATIVE, signs if n % 2 == 0 else POSITIVE)
            if n % 1:  # no whole number: where the power has a value, its base is positive, whatever its bounds say
                by_base = POSITIVE if n >= 0 else NEGATIVE
        by_exponent = EITHER if b is None else POSITIVE if b >= 1 else NEGATIVE
        return [by_base, by_exponent]
