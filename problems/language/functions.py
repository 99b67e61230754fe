"""Functions of the file, `drag(v, h): 0.5*rho*v**2*exp(-h/H)`, written out where they are called.

A call becomes the tree of the body with the arguments in place of their names: what comes after knows no functions, so
that derivatives, signs, abs and min, export and error estimate are those of the expression itself. The pieces of a body
have the place of the call in the text, so that a message shows the call.

At an end of time, `drag(v[final], h[final])`, the other names of the body are taken at the end of the arguments.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from typing import NamedTuple

from ..expressions.expression import Expression
from ..expressions.signature import Signature, name_trouble, signature
from ..expressions.tree import Link, Lookup, Name, Node, OperatorChain, Written, below, leaves, nodes, placed, rebuilt
from ..lean.records import dataclass
from ..names.circles import untangle
from ..names.symbols import UNKNOWN
from ..schema.spec import Spec
from ..text import excerpt
from ..yaml.document import Path
from ..yaml.locations import Finding
from .walk import changed, expressions_of, mapped

MAX_SIZE = 20_000  # nodes of one expression with its functions written out
MAX_DEPTH = 150  # of its tree, which is walked recursively


class DeclaredFunction(NamedTuple):
    """A function of the file: its key under expressions:, what that means, and the tree of its body."""

    key: str
    signature: Signature
    body: Node


def declared(spec: Spec) -> dict[str, DeclaredFunction]:
    """Name -> function; of several with one name the last."""
    found = ((key, signature(key), entry.value.root) for key, entry in spec.expressions.items() if "(" in key)
    return {own.name: DeclaredFunction(key, own, body) for key, own, body in found if own}


def without_functions(spec: Spec, marked: bool = False) -> tuple[Spec, list[Finding]]:
    """The spec without calls of functions, and what is wrong with those that it had.

    spec: of a file or of one phase. Its functions stay under their keys, for checks of the names in their bodies; each
    argument is something unknown there. So is a mistaken call.
    marked: whether what is written out says of which function it is (`tree.Written`).
    """
    own = declared(spec)
    if not own:
        return spec, []
    writer = _Writer(spec, own, marked)
    return changed(spec, writer.expression), writer.findings


@dataclass(frozen=True)
class _Body:
    """A function with all calls in its body written out.

    size, depth: of the tree. times: how often each name stands in it.
    """

    declared: DeclaredFunction
    root: Node
    size: int
    depth: int
    times: Mapping[str, int]


class _Tree(NamedTuple):
    root: Node
    size: int
    depth: int


class _Mistaken(Exception):  # noqa: N818 - it ends the writing of one expression
    pass


class _Writer:
    """Writes calls out; `findings` are the mistakes in them, each at the expression where it stands."""

    def __init__(self, spec: Spec, own: Mapping[str, DeclaredFunction], marked: bool):
        self.spec, self.declared, self.marked = spec, own, marked
        self.findings: list[Finding] = []
        self.bodies: dict[str, _Body] = {}
        self.varying = _varying(spec)
        # a name that something else has as well is told of where it is declared
        self.alone = own.keys() - self.varying - spec.parameters.keys() - spec.optimize.keys() - spec.expressions.keys()
        self.path: Path = ()
        self.text = ""
        graph = {name: _called(function.body) & own.keys() for name, function in own.items()}
        order, circles = untangle(graph)
        for circle in circles:
            what = f"{' -> '.join(circle[:10])} is a circle: each function calls the next"
            self.findings.append(Finding(("expressions", own[circle[0]].key), what, f"give {circle[0]} without itself"))
        for name in order:
            self._body(own[name])

    def expression(self, path: Path, expression: Expression) -> Expression:
        """The expression without calls; something unknown in place of a mistaken one."""
        self.path, self.text = path, expression.text
        if path[0] == "expressions" and "(" in str(path[1]):
            return self._unknown_arguments(str(path[1]), expression)
        if not self._concerned(expression.root):
            return expression
        try:
            return replace(expression, root=self._tree(expression.root).root)
        except _Mistaken:
            return replace(expression, root=UNKNOWN.root)

    def _concerned(self, root: Node) -> bool:
        """Whether a function is called in a tree, or named without arguments."""
        return any(
            (isinstance(node, Lookup) and node.table in self.declared)
            or (isinstance(node, Name) and node.name in self.alone)
            for node in nodes(root)
        )

    def _body(self, function: DeclaredFunction) -> None:
        self.path, self.text = ("expressions", function.key), self.spec.expressions[function.key].value.text
        try:
            tree = self._tree(function.body, own=frozenset(function.signature.arguments))
        except _Mistaken:
            return
        times = Counter(leaf.name for leaf in leaves(tree.root))
        self.bodies[function.signature.name] = _Body(function, *tree, times)

    def _unknown_arguments(self, key: str, expression: Expression) -> Expression:
        """The body of a function, as far as its names can be checked where it is declared: it has no value."""
        own = signature(key)
        root = self.bodies[own.name].root if own and own.name in self.bodies else UNKNOWN.root
        unknown = {name: UNKNOWN.root for name in own.arguments} if own else {}
        root = _substituted(root, unknown)
        span = 0, len(expression.text)
        return replace(expression, root=OperatorChain(*span, root, (Link(*span, "+", UNKNOWN.root),)))

    def _tree(self, node: Node, own: frozenset[str] = frozenset()) -> _Tree:
        """A tree with its calls written out. own: the arguments of the function whose body it is."""
        if isinstance(node, Name) and node.name in own:
            if node.end:
                self._refuse(node, f"{node.name} is an argument here, and has one value", f"write {node.name}")
            return _Tree(node, 1, 1)
        if isinstance(node, Name) and node.name in self.alone:
            called = self.declared[node.name].signature.called
            self._refuse(node, f"{node.name} is a function", f"give it its arguments: {called}")
        parts = [self._tree(part, own) for part in below(node)]
        if isinstance(node, Lookup) and node.table in self.declared:
            return self._call(node, parts)
        new = rebuilt(node, [part.root for part in parts]) if parts else node
        return self._within(
            node, _Tree(new, 1 + sum(p.size for p in parts), 1 + max((p.depth for p in parts), default=0))
        )

    def _call(self, node: Lookup, given: list[_Tree]) -> _Tree:
        """The body of a function with what it is given in place of its arguments."""
        wanted = self.declared[node.table].signature
        if any(name_trouble(name) for name in wanted.arguments):  # told where it is declared
            raise _Mistaken
        if len(given) != len(wanted.arguments):
            many = f"{len(wanted.arguments)} argument{'s' * (len(wanted.arguments) > 1)}"
            self._refuse(node, f"{node.table} takes {many}, not {len(given)}", f"write {wanted.called}")
        body = self.bodies.get(node.table)
        if body is None:  # its own mistake is told where it is declared
            raise _Mistaken
        by_name = dict(zip(wanted.arguments, given, strict=True))
        size = body.size + sum(body.times.get(name, 0) * tree.size for name, tree in by_name.items())
        depth = body.depth + max(tree.depth for tree in given)
        self._within(node, _Tree(node, size, depth))
        root = self._at_end(node, body.root, by_name)
        span = node.start, node.stop
        root = Written(*span, root, (), body.declared.key) if self.marked else root
        root = placed(root, *span)
        return _Tree(_substituted(root, {name: tree.root for name, tree in by_name.items()}), size, depth)

    def _at_end(self, node: Lookup, body: Node, given: Mapping[str, _Tree]) -> Node:
        """The body with its own names at the end of time, and in the phase, of the arguments."""
        names = [name for tree in given.values() for name in leaves(tree.root)]
        ends = {name.end for name in names if name.end}
        if not ends:
            return body
        phases = {name.name.partition(".")[0] for name in names if "." in name.name}
        free = {name.name for name in leaves(body) if not name.end} - given.keys()
        unclear = sorted(free & self.varying)
        if unclear and (len(ends) > 1 or len(phases) > 1):
            what = f"{node.table} uses {unclear[0]}, and it is not clear at which end it is meant"
            self._refuse(node, what, f"make {unclear[0]} an argument of {node.table}")
        end, phase = min(ends), f"{min(phases)}." if phases else ""
        own = free - self.spec.optimize.keys() if len(phases) == 1 else free & self.varying
        return mapped(
            body,
            lambda name: _taken(name, phase, end if name.name in self.varying else None) if name.name in own else name,
        )

    def _within(self, node: Node, tree: _Tree) -> _Tree:
        if tree.size > MAX_SIZE or tree.depth > MAX_DEPTH:
            what = "with its functions written out, this is too large an expression"
            self._refuse(node, what, "name parts of it under expressions:, without arguments")
        return tree

    def _refuse(self, node: Node, what: str, remedy: str) -> None:
        where = excerpt(self.text, node.start, node.stop)
        self.findings.append(Finding(self.path, f"{where}: {what}", remedy))
        raise _Mistaken


def called_functions(spec: Spec) -> set[str]:
    """The keys of the functions that expressions of a spec call, before they are written out."""
    if not (known := declared(spec)):
        return set()
    names = {name for _, expression in expressions_of(spec) for name in _called(expression.root)}
    return {function.key for name, function in known.items() if name in names}


def _called(root: Node) -> set[str]:
    return {node.table for node in nodes(root) if isinstance(node, Lookup)}


def _varying(spec: Spec) -> set[str]:
    """The names that have a value at every time."""
    found = {"t", *spec.states, *spec.controls, *spec.algebraic}
    found |= {entry.velocity_of(name) for name, entry in spec.states.items() if entry.second_order}
    waiting = {name: {leaf.name for leaf in entry.value.leaves} for name, entry in spec.expressions.items()}
    while new := {name for name, needs in waiting.items() if needs & found}:
        found |= new
        waiting = {name: needs for name, needs in waiting.items() if name not in new}
    return found


def _taken(name: Name, phase: str, end: str | None) -> Name:
    return replace(name, name=f"{phase}{name.name}", end=end)


def _substituted(node: Node, values: Mapping[str, Node]) -> Node:
    """A tree with others in place of names."""
    return mapped(node, lambda name: values.get(name.name, name))
