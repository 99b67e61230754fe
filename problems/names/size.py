"""Expressions that are too large to be differentiated twice: refused before any time is taken."""

from __future__ import annotations

from collections.abc import Collection, Hashable, Iterator
from typing import NamedTuple

from ..expressions.functions import FUNCTIONS
from ..expressions.tree import Lookup, Name, Node, Number, Operation, OperatorChain, below, skeleton
from ..yaml.document import Path
from ..yaml.locations import Finding
from .occurrences import CONSTANT
from .symbols import Symbols

WIDE = 16  # factors; dynamics that people write have fewer in a product, and most computer algebra gives fewer too
MOST = 1.5e8
"""Of n^2 W: products of W factors have n = sum W^2 / 2 products in their second derivatives, and SymEngine looks for
common parts in all pairs of these. Measured: 2.2e-8 s each, so that one product of 57 factors takes some 4 s."""
DEEPEST = 150  # functions of functions: their second derivatives have as many factors
LONGEST = 300  # names that stand for names: each evaluation goes through all of them

_REMEDY = "make a part of it a state, or an algebraic variable with a residual"


class _Size(NamedTuple):
    """factors: the different ones, constants left out, if it is a product. depth: of functions of functions."""

    factors: frozenset[Hashable]
    depth: int


def too_large(symbols: Symbols) -> Iterator[Finding]:
    """The expression that would keep the compiler busy for too long, if there is one; symbols: otherwise right."""
    known: dict[str, _Size] = {}
    lengths: dict[str, int] = {}
    for name, definition in symbols.definitions.items():  # after those that they refer to
        lengths[name] = 1 + max((lengths.get(leaf.name, 0) for leaf in definition.leaves), default=0)
        if lengths[name] > LONGEST:
            what = f"it stands for names that stand for names, more than {LONGEST} in a row"
            yield Finding(("expressions", name), what, "write some of them out in others")
            return
        known[name] = _Walk(known, symbols.numbers).node(definition.root)
    widest: dict[Path, int] = {}
    wide: list[int] = []
    for use in symbols.uses:
        if use.context == CONSTANT:
            continue
        walk = _Walk(known, symbols.numbers)
        factors, depth = walk.node(use.expression.root)
        if use.path[0] != "expressions":  # elsewhere the product of a definition may be part of a larger one
            walk.close(factors)
        if depth > DEEPEST:
            what = f"functions are nested {depth} deep, more than the {DEEPEST} that can be differentiated"
            yield Finding(use.path, what, _REMEDY)
            return
        widest[use.path] = max([*walk.widths, len(factors)])
        wide += (width for width in walk.widths if width >= WIDE)
    if sum(width**2 / 2 for width in wide) ** 2 * max(wide, default=0) > MOST:
        path = max(widest, key=widest.__getitem__)
        many = f"{len(wide)} products of up to" if len(wide) > 1 else "a product of"
        what = f"{many} {max(wide)} different factors has second derivatives that are too large to compile"
        yield Finding(path, what.replace(" has ", " have ") if len(wide) > 1 else what, _REMEDY)


class _Walk:
    """The products of one expression. widths: their numbers of factors, where they are no part of a larger one.

    known: name -> the size of the definition that it stands for. constants: names of numbers.
    """

    def __init__(self, known: dict[str, _Size], constants: Collection[str]) -> None:
        self.known, self.constants = known, constants
        self.widths: list[int] = []

    def close(self, factors: frozenset[Hashable]) -> None:
        """A product ends here: it is a term of a sum, or an argument."""
        self.widths.append(len(factors))

    def node(self, node: Node) -> _Size:
        match node:
            case Number():
                return _Size(frozenset(), 0)
            case Name(name=name, end=end):
                own = frozenset() if name in self.constants else frozenset([(name, end)])
                return self.known.get(name, _Size(own, 0))
            case OperatorChain():
                return self.chain(node)
            case Operation(symbol="-", operands=(operand,)):
                return self.node(operand)
            case Operation(symbol="**", operands=(base, Number())):
                factors, depth = self.node(base)
                return _Size(factors, depth + 1)
        depth = 0
        for operand in below(node):
            factors, inner = self.node(operand)
            self.close(factors)
            depth = max(depth, inner)
        deeper = isinstance(node, Lookup) or (isinstance(node, Operation) and node.symbol in (*FUNCTIONS, "**"))
        return _Size(frozenset([skeleton(node)]), depth + deeper)

    def chain(self, chain: OperatorChain) -> _Size:
        """A product of products, or a sum, which is one factor."""
        factors, depth = self.node(chain.first)
        for link in chain.links:
            own, inner = self.node(link.operand)
            depth = max(depth, inner)
            if link.symbol in "+-":
                self.close(factors)
                self.close(own)
                factors = frozenset([skeleton(chain)])
            else:
                factors |= own
        return _Size(factors, depth)
