"""Damage of what is in an HDF5 file: each kind changes one object or one attribute, in place."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np

Damage = Callable[[h5py.Group, str], None]
"""Changes the member or attribute of that name."""

PLENTY = 10**12
COMPRESSED = 3 * 10**8  # zeros, which make a file of some hundred kB
SECRET = "/etc/hostname"
"""A file of the system that nothing may print."""


def _again(group: h5py.Group, name: str, **how: object) -> None:
    """The dataset made anew."""
    del group[name]
    group.create_dataset(name, **how)


def _scaled(change: Callable[[np.ndarray], object]) -> Damage:
    """Damage that replaces the values of a dataset."""

    def damage(group: h5py.Group, name: str) -> None:
        values = np.asarray(group[name][()])
        if values.dtype.kind == "O":
            values = np.arange(values.size, dtype=float).reshape(values.shape)
        _again(group, name, data=change(values))

    return damage


def _one(value: float) -> Callable[[np.ndarray], np.ndarray]:
    """Values with one of them in the middle replaced."""

    def change(values: np.ndarray) -> np.ndarray:
        new = np.array(values, float)
        new[(new.size // 2,) if new.ndim == 1 else ...] = value
        return new

    return change


def _to_group(group: h5py.Group, name: str) -> None:
    del group[name]
    group.create_group(name)


def _to_array(group: h5py.Group, name: str) -> None:
    del group[name]
    group[name] = np.arange(3.0)


def _link(link: object) -> Damage:
    def damage(group: h5py.Group, name: str) -> None:
        del group[name]
        group[name] = link

    return damage


def _moved(group: h5py.Group, name: str) -> None:
    """A soft link to what was there, elsewhere in the file."""
    group.move(name, f"{name}-moved")
    group[name] = h5py.SoftLink(f"{group.name.rstrip('/')}/{name}-moved")


def _external_file(group: h5py.Group, name: str) -> None:
    """The same object in another file, which is there."""
    place, other = f"{group.name.rstrip('/')}/{name}", group.file.filename + ".other"
    with h5py.File(other, "w") as file:
        group.file.copy(group[name], file, name=place)
    del group[name]
    group[name] = h5py.ExternalLink(other, place)


def _cycle(group: h5py.Group, name: str) -> None:
    del group[name]
    group[name] = group.file["/"]


def _virtual(group: h5py.Group, name: str) -> None:
    shape = group[name].shape or (1,)
    layout = h5py.VirtualLayout(shape=shape, dtype=float)
    layout[...] = h5py.VirtualSource(group.file.filename + ".other", "/x", shape=shape)
    del group[name]
    group.create_virtual_dataset(name, layout)


def _stored_outside(group: h5py.Group, name: str) -> None:
    _again(group, name, shape=(8,), dtype="i1", external=[(SECRET, 0, h5py.h5f.UNLIMITED)])


def _huge(group: h5py.Group, name: str) -> None:
    _again(group, name, shape=(PLENTY,) * max(len(group[name].shape), 1), dtype=float, chunks=True)


def _bomb(group: h5py.Group, name: str) -> None:
    shape = group[name].shape or (1,)
    _again(group, name, shape=(COMPRESSED, *shape[1:]), dtype="i1", compression="gzip", chunks=True, fillvalue=0)


def _filtered(group: h5py.Group, name: str) -> None:
    values = np.atleast_1d(group[name][()])
    _again(group, name, data=np.zeros(values.shape), compression="lzf")


def _empty(group: h5py.Group, name: str) -> None:
    _again(group, name, data=h5py.Empty("f8"))


def _compound(values: np.ndarray) -> np.ndarray:
    return np.zeros(values.shape, [("a", "f8"), ("b", "i4")])


ARRAYS: dict[str, Damage] = {
    "text": _scaled(lambda v: np.full(v.shape, "\x1b[31mred", object)), "whole": _scaled(lambda v: v.astype(int)),
    "no utf-8": _scaled(lambda v: np.full(v.shape, b"\xff", h5py.string_dtype())),
    "complex": _scaled(lambda v: v + 1j), "compound": _scaled(_compound),
    "group": _to_group, "single": _scaled(lambda v: float(np.ravel(v)[0]) if v.size else 0.0),
    "longer": _scaled(lambda v: np.resize(v, (v.shape or (1,))[0] + 1)),
    "none": _scaled(lambda v: v[:0] if v.ndim else v),
    "shorter": _scaled(lambda v: v[:-1] if v.ndim else np.zeros(2)), "axis": _scaled(lambda v: v[..., None]),
    "nan": _scaled(_one(np.nan)), "inf": _scaled(_one(np.inf)), "minus inf": _scaled(_one(-np.inf)),
    "all nan": _scaled(lambda v: np.full(v.shape, np.nan)), "zeros": _scaled(np.zeros_like),
    "negative": _scaled(lambda v: -np.abs(v) - 1), "large": _scaled(lambda v: np.asarray(v, float) * 1e200),
    "reversed": _scaled(lambda v: v[::-1] if v.ndim else v), "huge": _huge, "bomb": _bomb, "virtual": _virtual,
    "stored outside": _stored_outside, "filter": _filtered, "empty": _empty,
}  # fmt: skip

ANY: dict[str, Damage] = {
    "deleted": lambda group, name: group.pop(name), "external": _external_file, "cycle": _cycle,
    "soft": _moved, "dangling": _link(h5py.SoftLink("/nowhere")), "outside": _link(h5py.ExternalLink(SECRET, "/")),
}  # fmt: skip

GROUPS: dict[str, Damage] = {
    "array": _to_array, "emptied": lambda group, name: group[name].clear(),
    "stranger": lambda group, name: group[name].__setitem__("a\x1b[31mb", np.arange(3.0)),
    "group in it": lambda group, name: group[name].create_group("x"),
    "renamed": lambda group, name: [group[name].move(own, f"{own}2") for own in list(group[name])[:1]],
}  # fmt: skip

ATTRIBUTES: dict[str, object] = {
    "text": "\x1b]0;title\x07\x1b[2J\n$\\frac{$", "long": "x" * 50_000, "bytes": np.bytes_(b"\xff\xfe"),
    "number": 1.5, "nan": np.nan, "inf": np.inf, "minus one": -1, "large": 2**62, "zero": 0, "tiny": 1e-320,
    "row": np.arange(3.0), "texts": ["a", "b"], "empty": h5py.Empty("f8"), "true": True, "false": False,
    "complex": 1j, "no utf-8": np.array(b"\xff\xfe", h5py.string_dtype()),
}  # fmt: skip


def damages(path: Path) -> Iterator[tuple[str, Callable[[Path], None]]]:
    """(name, function that does it to a copy) for every object and attribute of a file, and every kind."""
    with h5py.File(path) as file:
        found: list[tuple[str, bool, list[str]]] = [("/", True, list(file.attrs))]
        file.visititems(lambda name, own: found.append((name, isinstance(own, h5py.Group), list(own.attrs))))
    for place, is_group, attributes in found:
        kinds = {**ANY, **(GROUPS if is_group else ARRAYS)} if place != "/" else {}
        for kind, damage in kinds.items():
            yield f"{place}: {kind}", _object_damage(place, damage)
        own = ["units"] if not is_group else attributes
        for name in own:
            yield f"{place} {name}: deleted", _attribute_damage(place, name, None)
            for kind, value in ATTRIBUTES.items():
                yield f"{place} {name}: {kind}", _attribute_damage(place, name, value)


def _object_damage(place: str, damage: Damage) -> Callable[[Path], None]:
    parent, _, name = place.rpartition("/")

    def apply(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            damage(file[parent or "/"], name)

    return apply


def _attribute_damage(place: str, name: str, value: object) -> Callable[[Path], None]:
    def apply(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            attributes = file[place].attrs
            if name in attributes:
                del attributes[name]
            if value is not None:
                attributes[name] = value

    return apply
