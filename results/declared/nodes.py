"""What HDF5's low level says of a group, an array or an attribute before its values are read."""

from __future__ import annotations

import mmap
import re
import struct
from typing import Any

import h5py

from .words import FLAG, NUMBER, OPTION, TEXT, TEXTS, WHOLE

SINGLE: tuple[int, ...] = ()
"""Shape of a single value."""


MOST_OF_A_HEAP = 2**32  # bytes


class LayoutError(Exception):
    """Where in the file something is not as it should be, and what."""

    def __init__(self, where: str, what: str) -> None:
        self.where, self.what = where, what
        super().__init__(f"{where}: {what}")


def endless(content: mmap.mmap | bytes) -> bool:
    """Whether HDF5 would go through the texts of a file for ever.

    content: of the file.

    Texts stand in heaps: a head of 16 bytes, then objects, each with its number and its size. HDF5 goes from one to the
    next by the size, also where that is 0, as in a part of a file that was blanked.
    """
    for found in re.finditer(rb"GCOL\x01\0\0\0", content):
        start = found.start()
        (size,) = struct.unpack("<Q", content[start + 8 : start + 16].ljust(8, b"\0"))
        place, end = start + 16, start + min(size, MOST_OF_A_HEAP, len(content) - start)
        while place + 16 <= end:
            number, taken = struct.unpack("<H6xQ", content[place : place + 16])
            step = 16 + -(-taken // 8) * 8 if number else taken
            if not step:
                return True
            place += step
    return False


def opened_node(node: h5py.h5g.GroupID, name: str, where: str) -> Any:
    """The group or array under a name of a group.

    node: the open group.
    name: in it.
    where: path of what is opened, for the message.

    Raises LayoutError if there is none, or a link to elsewhere.
    """
    spelt = name.encode()
    if not node.links.exists(spelt):
        raise LayoutError(where, "it is missing")
    if node.links.get_info(spelt).type != h5py.h5l.TYPE_HARD:
        raise LayoutError(where, "it is a link to another place, which is not followed")
    return h5py.h5o.open(node, spelt)


def member_names(node: h5py.h5g.GroupID, where: str) -> list[str]:
    """The names of all members, in the order of their making. Raises LayoutError for what is no name."""
    names = [name.decode(errors="surrogateescape") for name in node]
    if odd := next((name for name in names if not name.isprintable() or name.startswith(".")), None):
        raise LayoutError(where, f"{odd!a} is no name")
    return names


def has(node: h5py.h5g.GroupID, name: str) -> bool:
    """Whether a group has a member."""
    return bool(node.links.exists(name.encode()))


def has_attribute(node: h5py.h5g.GroupID, name: str) -> bool:
    """Whether a group has an attribute."""
    return bool(h5py.h5a.exists(node, name.encode()))


def storage_kind(type_: h5py.h5t.TypeID) -> str:
    """What values of an HDF5 type are; "" for what no result has."""
    if type_ == h5py.h5t.IEEE_F64LE:
        return NUMBER
    if isinstance(type_, h5py.h5t.TypeStringID):
        return TEXT if type_.is_variable_str() else "a text of fixed length"
    try:
        known = type_.dtype
    except (TypeError, ValueError):
        return ""
    if known.kind == "b":
        return FLAG
    kinds = {"f": NUMBER, "i": WHOLE, "u": WHOLE}
    return kinds.get(known.kind, "") if known.itemsize <= 8 and known.metadata is None else ""


def fits(kind: str, declared: str) -> bool:
    """Whether values of a kind can stand where one is declared."""
    also = {NUMBER: (WHOLE,), TEXTS: (TEXT,), OPTION: (TEXT, NUMBER, WHOLE, FLAG)}
    return kind == declared or kind in also.get(declared, ())


def shape_of_node(node: h5py.h5d.DatasetID | h5py.h5a.AttrID, where: str) -> tuple[int, ...]:
    """The shape of an array or an attribute. Raises LayoutError if it has no value at all."""
    space = node.get_space()
    if space.get_simple_extent_type() == h5py.h5s.NULL:
        raise LayoutError(where, "it has no value")
    return SINGLE if space.get_simple_extent_type() == h5py.h5s.SCALAR else space.get_simple_extent_dims()
