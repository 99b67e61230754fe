"""Whether a file is as the layout declares it: looked at before anything is read, with nothing followed out of it."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import field
from typing import Any

import h5py
import numpy as np

from ...problems.lean.records import dataclass
from ...problems.text import shorten
from .layout import UNITS
from .nodes import LayoutError, fits, has, has_attribute, member_names, opened_node, shape_of_node, storage_kind
from .words import TEXT, TEXTS, Array, Attribute, Each, Group, Size

KNOWN_FILTERS = {h5py.h5z.FILTER_DEFLATE, h5py.h5z.FILTER_SHUFFLE, h5py.h5z.FILTER_FLETCHER32}
LARGEST = 4 * 2**30  # bytes of all arrays together: more is not read into memory
MOST_COMPRESSED = 100  # times its size: what a file of compressed arrays may hold
SMALL = 2**20  # bytes that any file may hold
ROUNDING = 1e-12  # of the largest time: so much may times be out of order


@dataclass
class SymbolValues:
    """What sizes and names the symbols stand for, as far as has been seen."""

    sizes: dict[str, int] = field(default_factory=dict)
    names: dict[str, set[str]] = field(default_factory=dict)


class Conformance:
    """The check of one file. size: of the file, in bytes."""

    def __init__(self, size: int) -> None:
        self.size = size
        self.plain = self.compressed = 0  # bytes that its arrays take in memory

    def group(self, node: h5py.h5g.GroupID, layout: Group, scope: SymbolValues, where: str = "") -> None:
        """Raise LayoutError if the group is not as the layout says.

        node: the open group.
        layout: of it.
        scope: what its symbols stand for; what is new in it is added.
        where: path of the group in the file, "" for the file itself.
        """
        for name, declared in layout.members.items():
            if name == "*":
                for other in (other for other in member_names(node, where) if other not in layout.members):
                    self._member(node, other, declared, scope, where)
            elif not _may_lack(node, declared, has) or has(node, name):
                self._member(node, name, declared, scope, where)
        for name, attribute in _attributes(node, layout):
            if has_attribute(node, name):
                self._attribute(node, name, attribute, scope, where or "/")
            elif not _may_lack(node, attribute, has_attribute):
                raise LayoutError(where or "/", f"its attribute {name} is missing")

    def _member(
        self, node: h5py.h5g.GroupID, name: str, declared: Array | Group | Each, scope: SymbolValues, where: str
    ) -> None:
        where = f"{where}/{name}"
        child = opened_node(node, name, where)
        if isinstance(declared, Array):
            if not isinstance(child, h5py.h5d.DatasetID):
                raise LayoutError(where, "it is no array")
            self._array(child, declared, scope, where)
            return
        if not isinstance(child, h5py.h5g.GroupID):
            raise LayoutError(where, "it is no group")
        if isinstance(declared, Group):
            self.group(child, declared, scope, where)
        else:
            self._each(child, declared, scope, where)

    def _each(self, node: h5py.h5g.GroupID, declared: Each, scope: SymbolValues, where: str) -> None:
        names = member_names(node, where)
        if declared.numbered and sorted(names) != sorted(map(str, range(len(names)))):
            raise LayoutError(where, f"its members are not named 0 to {len(names) - 1}")
        if len(names) < declared.least:
            raise LayoutError(where, "it is empty")
        if declared.names and (names or not declared.or_none):
            _agree(scope, declared.names, names, where)
        for name in names:
            inner = SymbolValues(dict(scope.sizes), dict(scope.names)) if declared.own else scope
            self._member(node, name, declared.member, inner, where)

    def _array(self, node: h5py.h5d.DatasetID, declared: Array, scope: SymbolValues, where: str) -> None:
        type_ = node.get_type()
        kind = storage_kind(type_)
        if not fits(kind, declared.kind):
            raise LayoutError(where, f"it holds {kind or 'what trajopt does not know'}, where {declared.kind} is meant")
        shape = shape_of_node(node, where)
        if len(shape) != len(declared.sizes):
            raise LayoutError(where, f"it has {len(shape)} axes, not {len(declared.sizes)}")
        for n, size in zip(shape, declared.sizes, strict=True):
            _bind(scope, size, n, where)
        self._storage(node, shape, type_.get_size(), where)
        if has_attribute(node, "units"):
            self._attribute(node, "units", UNITS, scope, where)
        if declared.kind == TEXT:
            _check_texts(h5py.Dataset(node), declared, scope, where)
        elif declared.ordered or declared.finite or declared.limits:
            _check_values(h5py.Dataset(node), declared, where)

    def _storage(self, node: h5py.h5d.DatasetID, shape: tuple[int, ...], item: int, where: str) -> None:
        """That the values, of so many bytes each, are in this file, in a way that is known, and not too many."""
        how = node.get_create_plist()
        kind, filters = how.get_layout(), set()
        if kind == h5py.h5d.VIRTUAL or (kind == h5py.h5d.CONTIGUOUS and how.get_external_count()):
            raise LayoutError(where, "its values are in another file, which is not opened")
        own = taken = item * math.prod(shape)
        if kind == h5py.h5d.CHUNKED and taken:
            taken = max(taken, item * math.prod(how.get_chunk()))
            filters = {how.get_filter(k)[0] for k in range(how.get_nfilters())}
        if filters - KNOWN_FILTERS:
            raise LayoutError(where, f"it is stored by a filter that is not read (number {max(filters)})")
        if h5py.h5z.FILTER_DEFLATE in filters:
            self.compressed += taken
        else:
            self.plain += taken
            if node.get_storage_size() < own:
                raise LayoutError(where, "its values are not in the file")
        room = self.size if not self.compressed else max(MOST_COMPRESSED * self.size, SMALL)
        if self.plain > self.size or self.plain + self.compressed > min(room, LARGEST):
            raise LayoutError(
                where, f"with it the arrays take {self.plain + self.compressed:.2g} bytes, which is too much"
            )

    def _attribute(
        self,
        node: h5py.h5g.GroupID | h5py.h5d.DatasetID,
        name: str,
        declared: Attribute,
        scope: SymbolValues,
        where: str,
    ) -> None:
        where = f"{where}, attribute {name}"
        told = h5py.h5a.open(node, name.encode())
        type_ = told.get_type()
        kind, shape = storage_kind(type_), shape_of_node(told, where)
        if not fits(kind, declared.kind):
            raise LayoutError(where, f"it holds {kind or 'what trajopt does not know'}, where {declared.kind} is meant")
        if len(shape) != (declared.kind == TEXTS) or math.prod(shape) > self.size:
            raise LayoutError(where, f"its shape is {shape}")
        if declared.limited:
            values = np.empty(shape, type_.dtype)
            told.read(values)
            _check_attribute(values, declared, scope, where)


def _check_attribute(values: np.ndarray, declared: Attribute, scope: SymbolValues, where: str) -> None:
    value: Any = values[()]
    if declared.one_of:
        word = (value or b"").decode(errors="replace")
        if word not in declared.one_of:
            raise LayoutError(where, f"{shorten(ascii(word), 40)} is not among {', '.join(declared.one_of)}")
        return
    if declared.finite and not np.isfinite(value):
        raise LayoutError(where, f"{value} is no finite number")
    if declared.above is not None and value <= declared.above:
        raise LayoutError(where, f"{value} is out of range")
    if declared.size:
        _bind(scope, declared.size, int(value), where)


def _check_texts(array: h5py.Dataset, declared: Array, scope: SymbolValues, where: str) -> None:
    try:
        texts = [text.decode() for text in np.atleast_1d(array[()])]
    except UnicodeDecodeError as error:
        raise LayoutError(where, f"its byte {error.start + 1} is no UTF-8") from error
    if not declared.names:
        return
    if len(set(texts)) < len(texts):
        raise LayoutError(where, "a name stands in it twice")
    _agree(scope, declared.names, texts, where)


def _check_values(array: h5py.Dataset, declared: Array, where: str) -> None:
    try:
        values = array[()]
    except OSError as error:
        raise LayoutError(where, "its values cannot be read") from error
    if declared.limits and ((values < declared.limits[0]) | (values > declared.limits[1])).any():
        raise LayoutError(where, f"its values are not between {declared.limits[0]} and {declared.limits[1]}")
    if (declared.ordered or declared.finite) and not np.isfinite(values).all():
        raise LayoutError(where, "not all of its values are finite")
    if not declared.ordered:
        return
    steps = np.diff(values)
    if declared.ordered == "edges" and not (values[0] == 0 and abs(values[-1] - 1) < 1e-9 and (steps > 0).all()):
        raise LayoutError(where, "its values do not rise from 0 to 1")
    rounding = ROUNDING * np.abs(values).max(initial=0.0)  # a phase may have shrunk to nothing
    if declared.ordered == "times" and not (steps >= -rounding).all() | (steps <= rounding).all():
        raise LayoutError(where, "its values are not in order")


def _agree(scope: SymbolValues, symbol: str, names: list[str], where: str) -> None:
    """The names are those of the symbol, which has its size, too."""
    known = scope.names.setdefault(symbol, set(names))
    if odd := sorted(known ^ set(names)):
        lacking = odd[0] in known
        raise LayoutError(where, f"{odd[0]!a} {'is missing' if lacking else f'is not among the {symbol}'}")
    scope.sizes.setdefault(symbol, len(names))


def _bind(scope: SymbolValues, size: Size, n: int, where: str) -> None:
    """An axis, or what repeats its size, has n values."""
    own = n - size.plus
    symbol = size.symbol
    if size.steps:
        segments = scope.sizes.get(symbol, 1)
        if own < segments or own % segments:
            raise LayoutError(where, f"it has {n} values, which {segments} {symbol} do not divide")
        symbol = f"samples of {symbol}"
    known = scope.sizes.setdefault(symbol, own)
    if own < size.least:
        raise LayoutError(where, "it has too few values")
    if own != known:
        raise LayoutError(where, f"it has {n} values, where there are {known} {symbol}")


def _may_lack(node: h5py.h5g.GroupID, declared: Array | Group | Each | Attribute, has: Any) -> bool:
    if isinstance(declared, Group | Each):
        return declared.optional
    if isinstance(declared, Array) and declared.unless and has(node, declared.unless):
        return True
    return declared.optional or bool(declared.along and not has(node, declared.along))


def _attributes(node: h5py.h5g.GroupID, layout: Group) -> Iterator[tuple[str, Attribute]]:
    """The declared attributes of a group: those with a name, and those there that begin as declared."""
    families = {name[:-1]: own for name, own in layout.attributes.items() if name.endswith("*")}
    yield from ((name, own) for name, own in layout.attributes.items() if not name.endswith("*"))
    if not families:
        return
    for name in h5py.AttributeManager(h5py.HLObject(node)):
        if name not in layout.attributes:
            own = next((own for start, own in families.items() if name.startswith(start)), None)
            if own:
                yield name, own
