"""Arithmetic of vectors and small matrices of texts: what + or cross makes of the components of its operands.

A text knows how firmly its last operation binds, so that parentheses stand only where they are needed. Products with 0
and 1 are left out: cross(w, [0, 0, h]) has no terms without a value.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import reduce
from itertools import product
from typing import Any, NamedTuple

from ..text import shorten

SUM, PRODUCT, POWER, ATOM = range(4)
"""How firmly the last operation of a text binds."""


class Scalar(NamedTuple):
    """One value: its text, and how firmly that binds."""

    text: str
    level: int = ATOM

    def at(self, level: int) -> str:
        """The text where something that binds as firmly as `level` is needed."""
        return self.text if self.level >= level else f"({self.text})"


Value = Scalar | list["Value"]
"""A scalar, a vector of them, or a matrix as a list of rows."""

Vector = list[Scalar]
Shape = tuple[int, ...]


class Unfit(Exception):  # noqa: N818 - it ends the reading of one text
    """Operands that do not go together. what: the mistake. remedy: how to mend it."""

    def __init__(self, what: str, remedy: str):
        self.what, self.remedy = what, remedy
        super().__init__(what)


def shape_of(value: Value) -> Shape:
    """The shape of a value: () for a scalar, (3,) for a vector of 3, (2, 3) for a matrix of 2 rows."""
    return () if isinstance(value, Scalar) else (len(value), *shape_of(value[0]))


def shape_in_words(shape: Shape) -> str:
    """What a value of a shape is."""
    if len(shape) < 2:
        return f"a vector of {shape[0]}" if shape else "one value"
    return f"a matrix of {' by '.join(map(str, shape))}"


def each(value: Value) -> Iterator[Scalar]:
    """The scalars of a value, row by row."""
    if isinstance(value, Scalar):
        yield value
        return
    for own in value:
        yield from each(own)


def indexed(value: Value) -> Iterator[tuple[tuple[int, ...], Scalar]]:
    """The scalars of a value with their indices, from 0, row by row."""
    return zip(product(*map(range, shape_of(value))), each(value), strict=True)


def each_mapped(value: Value, new: Callable[[Scalar], Scalar]) -> Value:
    """A value of the same shape."""
    return new(value) if isinstance(value, Scalar) else [each_mapped(own, new) for own in value]


def minus(a: Scalar) -> Scalar:
    return a if a.text == "0" else Scalar(f"-{a.at(PRODUCT)}", SUM)


def plus(a: Scalar, b: Scalar) -> Scalar:
    if "0" in (a.text, b.text):
        return b if a.text == "0" else a
    return Scalar(f"{a.text} + {b.at(PRODUCT)}", SUM)


def less(a: Scalar, b: Scalar) -> Scalar:
    if "0" in (a.text, b.text):
        return minus(b) if a.text == "0" else a
    return Scalar(f"{a.text} - {b.at(PRODUCT)}", SUM)


def times(a: Scalar, b: Scalar) -> Scalar:
    if "0" in (a.text, b.text):
        return Scalar("0")
    if "1" in (a.text, b.text):
        return b if a.text == "1" else a
    return Scalar(f"{a.at(PRODUCT)}*{b.at(POWER)}", PRODUCT)


def over(a: Scalar, b: Scalar) -> Scalar:
    return Scalar(f"{a.at(PRODUCT)}/{b.at(POWER)}", PRODUCT)


def power(a: Scalar, b: Scalar) -> Scalar:
    return Scalar(f"{a.at(ATOM)}**{b.at(ATOM)}", POWER)


def total(terms: Sequence[Scalar]) -> Scalar:
    return reduce(plus, terms)


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    return total([times(x, y) for x, y in zip(a, b, strict=True)])


def cross(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    return [less(times(a[i], b[j]), times(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]


def quat_mul(p: Sequence[Scalar], q: Sequence[Scalar]) -> list[Scalar]:
    """Hamilton's product of quaternions with their scalar part last: p4 q + q4 p + p x q, and p4 q4 - p.q."""
    turned = cross(p[:3], q[:3])
    head = [plus(plus(times(p[3], q[i]), times(q[3], p[i])), turned[i]) for i in range(3)]
    return [*head, less(times(p[3], q[3]), dot(p[:3], q[:3]))]


def rotate(q: Sequence[Scalar], v: Sequence[Scalar]) -> list[Scalar]:
    """A vector turned by a unit quaternion, q v q*: v + 2 q4 (q x v) + 2 q x (q x v)."""
    once = cross(q[:3], v)
    twice = cross(q[:3], once)
    two = Scalar("2")
    return [plus(v[i], times(two, Scalar(plus(times(q[3], once[i]), twice[i]).text, SUM))) for i in range(3)]


def norm(v: Sequence[Scalar]) -> Scalar:
    return Scalar(f"norm({', '.join(own.text for own in v)}{', 0' * (len(v) == 1)})")


def quat_conj(q: Sequence[Scalar]) -> list[Scalar]:
    return [*map(minus, q[:3]), q[3]]


def transpose(matrix: Sequence[Sequence[Scalar]]) -> list[Vector]:
    return [list(row) for row in zip(*matrix, strict=True)]


class VectorFunction(NamedTuple):
    """A function that takes vectors as a whole.

    sizes: of its operands; 0 for any size, None for a matrix.
    work: of the operands.
    written: how it is called.
    """

    sizes: tuple[int | None, ...]
    work: Callable[..., Any]
    written: str


_LAST = "whose scalar part is last"

FUNCTIONS: dict[str, VectorFunction] = {
    "dot": VectorFunction((0, 0), dot, "dot(a, b)"),
    "cross": VectorFunction((3, 3), cross, "cross(a, b) with vectors of 3; in the plane a[1]*b[2] - a[2]*b[1]"),
    "sum": VectorFunction((0,), total, "sum(a)"),
    "norm": VectorFunction((0,), norm, "norm(a)"),
    "quat_mul": VectorFunction((4, 4), quat_mul, f"quat_mul(p, q) with quaternions {_LAST}"),
    "quat_conj": VectorFunction((4,), quat_conj, f"quat_conj(q) with a quaternion {_LAST}"),
    "rotate": VectorFunction((4, 3), rotate, f"rotate(q, v) with a quaternion {_LAST}, and a vector of 3"),
    "transpose": VectorFunction((None,), transpose, "transpose(A) with a list of rows"),
}
"""One row for each of them; `norm` of several scalars, and `sum` over a loop, are of the language without vectors."""


_MADE = "a state or a control is a vector by size: 3 beside it, a parameter by a list"


def of_vectors(name: str, given: Sequence[Value], shown: Sequence[str]) -> Value:
    """The value of one of these functions. Raises Unfit for operands that it does not take.

    name: of the function.
    given: its operands.
    shown: their texts in the file.
    """
    row = FUNCTIONS[name]
    if len(given) != len(row.sizes):
        what = f"{name} takes {len(row.sizes)} argument{'s' * (len(row.sizes) > 1)}, not {len(given)}"
        raise Unfit(what, f"write {row.written}")
    for size, own, text in zip(row.sizes, given, shown, strict=True):
        shape = shape_of(own)
        if len(shape) != (2 if size is None else 1) or (size and shape != (size,)):
            takes = "a matrix" if size is None else f"a vector of {size}" if size else "vectors"
            remedy = f"write {row.written}" + ("" if shape else f"; {_MADE}")
            raise Unfit(f"{name} takes {takes}, and {shorten(text, 40)} is {shape_in_words(shape)}", remedy)
    if name == "dot" and shape_of(given[0]) != shape_of(given[1]):
        told = " and ".join(shape_in_words(shape_of(own)) for own in given)
        raise Unfit(f"{told} do not go together", "make both of one length")
    value: Value = row.work(*given)
    return value


def as_vector(value: Value) -> Value:
    """A matrix of one column as the vector that it is; other values as they are."""
    if isinstance(value, Scalar) or shape_of(value)[1:] != (1,):
        return value
    return [own for row in value for own in each(row)]


def elementwise(work: Callable[..., Scalar], *operands: Value) -> Value:
    """What a function of scalars makes of operands of one shape, component by component; a scalar goes with all.

    Raises Unfit for other shapes.
    """
    shapes = {shape_of(own) for own in operands} - {()}
    if not shapes:
        return work(*operands)
    if len(shapes) > 1:
        operands = tuple(map(as_vector, operands))
        shapes = {shape_of(own) for own in operands} - {()}
    if len(shapes) > 1:
        told = " and ".join(shape_in_words(shape_of(own)) for own in operands)
        mixed = {len(shape) for shape in shapes} == {1, 2}
        remedy = "make both of one shape; a matrix of n columns times a vector of n is A @ x"
        raise Unfit(f"{told} do not go together", remedy if mixed else "make both of one length")
    count = next(iter(shapes))[0]
    parts = [own if isinstance(own, list) else [own] * count for own in operands]
    return [elementwise(work, *own) for own in zip(*parts, strict=True)]


def matrix_product(a: Any, b: Any) -> Value:
    """a @ b, of two vectors their dot product. Raises Unfit where the rows of a are not as long as b."""
    left, right = shape_of(a), shape_of(b)
    if not left or not right or left[-1] != right[0]:
        what = f"{shape_in_words(left)} and {shape_in_words(right)} have no product @"
        raise Unfit(what, "multiply a matrix by a vector that is as long as its rows, and one value by *")
    rows = a if len(left) == 2 else [a]
    columns = transpose(b) if len(right) == 2 else [b]
    entries: list[Any] = [[dot(row, column) for column in columns] for row in rows]
    if len(right) == 1:
        entries = [row[0] for row in entries]
    return entries if len(left) == 2 else entries[0]
