"""abs, min and max made consistent, for any expression of a problem (paper, sections 5.5 and 8.5-8.6).

Each occurrence that varies is replaced in the tree of its expression, before parameters are bound to it. By smoothing,
it becomes an operation of `expressions.smooth`. By slack variables, |y| becomes s1 + s2 with s1, s2 >= 0 and
y - s1 + s2 = 0: two controls and a path constraint, or two static parameters and a boundary constraint where y is taken
at the ends of time or does not vary. Then s1 + s2 >= |y| only, which is as good where the problem gains by making it
small: a small value must nowhere raise a minimised objective, nor be needed to keep a constraint. Whether it is so,
`Monotone` tells.
Elsewhere s1 s2 <= 0 is added, which makes the sum exact and the problem harder.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import field, replace
from itertools import count as numbers_from
from typing import NamedTuple

from ..expressions.expression import Expression
from ..expressions.functions import EITHER, FUNCTIONS, NEGATIVE, POSITIVE, Signs, is_inconsistent
from ..expressions.smooth import SLACK, stand_in
from ..expressions.tree import Link, Name, Node, Number, Operation, OperatorChain, below, nodes, placed, rebuilt
from ..language.walk import mapped
from ..lean.records import dataclass
from ..names.occurrences import BOUNDARY, CONSTANT, SOLVED, TRAJECTORY, Use, constraint_names
from ..names.symbols import Symbols
from ..quantities import Range, Variable
from ..schema.sections import Nonsmooth
from ..schema.spec import Spec
from ..text import excerpt
from ..yaml.document import Path
from ..yaml.locations import Finding
from .signs import Monotone, negative, product_of_signs

NONNEGATIVE = Range(lower=0.0)

_JUMPS = (
    "is not a consistent function: its gradient jumps, and the solver then fails to converge (Kelly 2017, section 5.5)"
)
_CHOICE = (
    "add a line that makes it so: nonsmooth: slack, exact, and best where a small abs is what is wanted, as in an "
    "objective; nonsmooth: {tanh: 0.01}, smooth and a little smaller; or nonsmooth: {sqrt: 0.01}, smooth and a little "
    "larger, where 0.01 is in the unit of the argument, and less is more exact and harder to solve"
)


class Relation(NamedTuple):
    """A constraint on slack variables, before parameters are bound to its expression."""

    name: str
    expression: Expression
    bounds: Range


@dataclass
class Consistent:
    """What takes the place of the expressions of a file, and what is added to its problem.

    expressions: path -> expression. definitions: name -> expression. controls and parameters: the slack variables.
    path and boundary: their constraints. warnings: where slack variables are not as good as smoothing.
    """

    expressions: dict[Path, Expression] = field(default_factory=dict)
    definitions: dict[str, Expression] = field(default_factory=dict)
    controls: list[Variable] = field(default_factory=list)
    parameters: list[Variable] = field(default_factory=list)
    path: list[Relation] = field(default_factory=list)
    boundary: list[Relation] = field(default_factory=list)
    warnings: list[Finding] = field(default_factory=list)


def untreated(spec: Spec, symbols: Symbols) -> Iterator[Finding]:
    """The occurrences of abs, min and max in a file that does not say how they become consistent."""
    for path, expression, context in symbols.uses:
        found = next(occurrences(expression.root, symbols), None)
        if found is not None and context in SOLVED and spec.nonsmooth is None:
            where = excerpt(expression.text, found.start, found.stop)
            yield Finding(path, f"{where}: {found.symbol} {_JUMPS}", _CHOICE)


def occurrences(root: Node, symbols: Symbols) -> Iterator[Operation]:
    """abs, min and max of anything that is not a constant."""
    for node in nodes(root):
        if isinstance(node, Operation) and is_inconsistent(node.symbol) and not symbols.is_constant(node):
            yield node


def consistent(spec: Spec, symbols: Symbols, mesh: int = -1, taken: frozenset[str] = frozenset()) -> Consistent:
    """The expressions that abs, min and max are taken out of, for an entry of the mesh schedule.

    spec, symbols: free of mistakes.
    mesh: index of the entry, which chooses one of several widths; -1 for the last.
    taken: names that slack variables must not have, beside those of the file.
    """
    if spec.nonsmooth is None:
        return Consistent(definitions=symbols.definitions)
    if spec.nonsmooth.treatment == SLACK:
        return _Slack(spec, symbols, spec.nonsmooth, taken).run()
    return _Smooth(spec, symbols, spec.nonsmooth, mesh).run()


class _Smooth:
    """Replaces every occurrence by its stand-in; place and sign of an expression matter to _Slack only."""

    def __init__(self, spec: Spec, symbols: Symbols, how: Nonsmooth, mesh: int = -1):
        self.spec, self.symbols, self.treatment, self.found = spec, symbols, how.treatment, Consistent()
        if widths := how.widths:
            self.width = symbols.number(widths[mesh if len(widths) > 1 else 0], 0.0)

    def run(self) -> Consistent:
        definitions = {name: self.definition(name, e) for name, e in self.symbols.definitions.items()}
        for use in self.symbols.uses:
            if use.context in SOLVED and use.path[0] != "expressions":
                self.found.expressions[use.path] = self.expression(use)
        self.found.definitions = definitions
        return self.found

    def definition(self, name: str, expression: Expression) -> Expression:
        return replace(expression, root=self.visit(expression.root, EITHER))

    def expression(self, use: Use) -> Expression:
        return replace(use.expression, root=self.visit(use.expression.root, EITHER))

    def visit(self, node: Node, wanted: Signs) -> Node:
        """The tree without abs, min and max. wanted: the signs of the slope of what is minimised by this node."""
        # From below, so that the y of an outer |y| stands on the slack variables of an inner one. By the chain rule the
        # slope of what is minimised by a part is that by the whole times that of the whole by the part.
        parts = zip(below(node), self.slopes(node), strict=True)
        new = rebuilt(node, [self.visit(part, product_of_signs(wanted, slope)) for part, slope in parts])
        if isinstance(new, Operation) and is_inconsistent(new.symbol) and not self.symbols.is_constant(node):
            return self.replaced(self._constants_first(new), wanted)
        return new

    def _constants_first(self, node: Operation) -> Operation:
        """min and max of the constants among the operands stay exact: one operand for all of them."""
        constants = [n for n in node.operands if self.symbols.is_constant(n)]
        if len(constants) < 2:
            return node
        rest = (n for n in node.operands if n not in constants)
        return replace(node, operands=(replace(node, operands=tuple(constants)), *rest))

    def slopes(self, node: Node) -> list[Signs]:
        return [EITHER] * len(below(node))

    def replaced(self, node: Operation, wanted: Signs) -> Node:
        width = Number(node.start, node.stop, self.width)
        return replace(node, symbol=stand_in(node.symbol, self.treatment), operands=(*node.operands, width))


class _Slack(_Smooth):
    """Replaces every |y| by slack variables; `self.use` is the expression at hand, a definition being one as well."""

    def __init__(self, spec: Spec, symbols: Symbols, how: Nonsmooth, taken: frozenset[str]):
        super().__init__(spec, symbols, how)
        trees = {name: expression.root for name, expression in symbols.definitions.items()}
        self.monotone = Monotone(_ranges(spec, symbols), symbols.constant_value, trees)
        self.nonsmooth = self._nonsmooth(trees)
        self.wanted = self._wanted()
        self.taken = {*symbols.roles, *constraint_names(spec), *taken}
        self.use = Use((), Expression("", Number(0, 0, 0.0)), CONSTANT)

    def definition(self, name: str, expression: Expression) -> Expression:
        if name not in self.wanted:
            return expression  # it is used at the ends alone, where it is written out
        self.use = Use(("expressions", name), expression, "")
        return replace(expression, root=self.visit(expression.root, self.wanted[name]))

    def expression(self, use: Use) -> Expression:
        self.use = use
        # at the ends a definition has values of its own, so the slack variables that it has over time do not serve
        root = self._written_out(use.expression.root) if use.context == BOUNDARY else use.expression.root
        return replace(use.expression, root=self.visit(root, self._wanted_of(use)))

    def slopes(self, node: Node) -> list[Signs]:
        return self.monotone.slopes(node)

    def replaced(self, node: Operation, wanted: Signs) -> Node:
        row = FUNCTIONS[node.symbol]
        if row.arguments == (1, 1):
            return self._sum(node, node.operands[0], wanted)
        operands = node.operands
        sums: list[Node] = []
        # min falls as its |a - b| grows, so what is wanted of that is the opposite of what is wanted of min
        of_abs = wanted if row.in_abs > 0 else negative(wanted)
        for k in range(1, len(operands)):
            so_far = _extreme(node, operands[:k], sums)
            difference = OperatorChain(node.start, node.stop, so_far, (Link(node.start, node.stop, "-", operands[k]),))
            sums.append(self._sum(node, difference, of_abs))
        return _extreme(node, operands, sums)

    def _sum(self, node: Operation, y: Node, wanted: Signs) -> Node:
        """s1 + s2 for |y|, and what it needs."""
        span, text = (node.start, node.stop), self.use.expression.text
        stem = self._stem(node.symbol)
        plus, minus = (Name(*span, f"{stem}_{side}", None) for side in ("plus", "minus"))
        over_time = self.use.context != BOUNDARY and any(self._varies(n) for n in nodes(y))
        variables, relations = self.found.controls, self.found.path
        if not over_time:
            variables, relations = self.found.parameters, self.found.boundary
        variables += [Variable(name.name, "", NONNEGATIVE) for name in (plus, minus)]
        definition = OperatorChain(*span, y, (Link(*span, "-", plus), Link(*span, "+", minus)))  # (8.11)
        relations.append(Relation(stem, Expression(text, definition), Range(0.0, 0.0)))
        if -1 in wanted:  # a sum larger than |y| would pay somewhere: only a constraint keeps it exact
            both = Expression(text, OperatorChain(*span, plus, (Link(*span, "*", minus),)))
            relations.append(Relation(f"{stem}_complementary", both, Range(upper=0.0)))
            self._warn(node, stem)
        return OperatorChain(*span, plus, (Link(*span, "+", minus),))  # (8.9)

    def _warn(self, node: Operation, stem: str) -> None:
        where = excerpt(self.use.expression.text, node.start, node.stop)
        needs = f"{stem}_plus*{stem}_minus <= 0"
        what = f"{where} stands where slack variables are exact only with {needs}, which is hard to solve"
        remedy = "nonsmooth: {tanh: 0.01} or {sqrt: 0.01} is usually better here"
        self.found.warnings.append(Finding(self.use.path, what, remedy))

    def _stem(self, symbol: str) -> str:
        """A name for a pair of slack variables, such as abs1, that leaves the names of the file alone."""
        for stem in (f"{symbol}{i}" for i in numbers_from(1)):
            names = {stem, f"{stem}_plus", f"{stem}_minus", f"{stem}_complementary"}
            if not names & self.taken:
                break
        self.taken |= names
        return stem

    def _varies(self, node: Node) -> bool:
        slack = {control.name for control in self.found.controls}
        return isinstance(node, Name) and (node.name in slack or self.symbols.varies(node.name))

    def _written_out(self, root: Node) -> Node:
        """The tree with definitions that hold abs, min or max written out, each name at the end that is meant."""
        if isinstance(root, Name) and root.name in self.nonsmooth:
            tree = self.symbols.definitions[root.name].root
            return self._written_out(_moved(tree, root, self.symbols.varies))
        return rebuilt(root, [self._written_out(node) for node in below(root)])

    def _nonsmooth(self, trees: Mapping[str, Node]) -> set[str]:
        """The definitions that hold abs, min or max, or a definition that does."""
        found: set[str] = set()
        for name, root in trees.items():
            own = next(occurrences(root, self.symbols), None)
            if own or any(isinstance(n, Name) and n.name in found for n in nodes(root)):
                found.add(name)
        return found

    def _wanted(self) -> dict[str, Signs]:
        """For each definition, the signs of the slope of what is minimised by it, over time."""
        wanted: dict[str, Signs] = {}

        def spread(node: Node, signs: Signs) -> None:
            if isinstance(node, Name) and node.name in self.symbols.definitions:
                wanted[node.name] = wanted.get(node.name, frozenset()) | signs
            for inner, slope in zip(below(node), self.monotone.slopes(node), strict=True):
                spread(inner, product_of_signs(signs, slope))

        for use in self.symbols.uses:
            if use.context == TRAJECTORY and use.path[0] != "expressions":
                spread(use.expression.root, self._wanted_of(use))
        # from the last: what refers to a definition comes after it, so that its own signs are complete by then
        for name in reversed(self.symbols.definitions):
            if name in wanted:
                spread(self.symbols.definitions[name].root, wanted[name])
        return wanted

    def _wanted_of(self, use: Use) -> Signs:
        """The signs of the slope of what is minimised by an expression: POSITIVE where small values are wanted."""
        match use.path:
            case ("objective", sense, _):
                return POSITIVE if sense == "minimize" else NEGATIVE
            case ("constraints", kind, i, _):
                constraint = getattr(self.spec.constraints, str(kind))[i]
        if use.path[0] != "constraints":
            return EITHER
        bounds, signs = self.symbols.range(constraint), self.monotone.signs(use.expression.root)
        # a bound that the sign alone keeps wants nothing
        above = bounds.upper < float("inf") and not (bounds.upper >= 0 and signs == NEGATIVE)
        under = bounds.lower > -float("inf") and not (bounds.lower <= 0 and signs == POSITIVE)
        return (POSITIVE if above else frozenset()) | (NEGATIVE if under else frozenset())


def _extreme(node: Operation, operands: tuple[Node, ...], sums: list[Node]) -> Node:
    """min or max of the operands by the slack sums of their differences."""
    if len(operands) == 1:
        return operands[0]
    return replace(node, symbol=stand_in(node.symbol, SLACK), operands=(*operands, *sums))


def _moved(tree: Node, name: Name, varies: Callable[[str], bool]) -> Node:
    """A tree in the place of a name: varying names in it are taken at the end that the name is taken at."""
    here = placed(tree, name.start, name.stop)
    return mapped(here, lambda own: replace(own, end=name.end if varies(own.name) else None))


def _ranges(spec: Spec, symbols: Symbols) -> dict[str, Range]:
    """The ranges of the values of every name that has bounds."""
    ranges = {v.name: symbols.range(v.entry) for v in symbols.variables}
    ranges |= {name: symbols.range(static) for name, static in spec.optimize.items()}
    return ranges | {"t": Range(symbols.range(spec.time.initial).lower, symbols.range(spec.time.final).upper)}
