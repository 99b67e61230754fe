"""Groups, dimension scales and arrays of a result file, as h5py makes them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from typing import Any
from uuid import uuid4

import h5py
import numpy as np
from h5py import h5a, h5s, h5t
from numpy.typing import ArrayLike

from ...problems.text import printable
from ...transcription.solution.solution import inaccurate

NO_BAR_YET = "an older version wrote this result"
"""Why there is no error bar of the objective, in a result that does not tell."""

NO_VARIABLE = "This is a netCDF dimension but not a netCDF variable."
"""The name of a dimension scale that netCDF does not take for one: of the netCDF-4 format specification."""

ONE_CHUNK = 2**26  # bytes

_ALONE = h5s.create(h5s.SCALAR)
_KINDS = {
    kind: (h5t.py_create(own, logical=True), h5t.py_create(own), own)
    for kind, own in ((str, h5py.string_dtype()), (float, np.dtype(np.float64)))
}
"""Of a value -> its type in the file, in memory, and as NumPy has it."""

LIBVER = ("v110", "v110")
"""The structures of HDF5 1.10, of 2016: they have check sums, and are smaller and read faster than the older ones."""


def texts(texts: Iterable[str]) -> np.ndarray:
    """An array of texts even if there are none, which h5py would take for numbers."""
    return np.array(list(texts), h5py.string_dtype())


@contextmanager
def file_in_memory() -> Iterator[h5py.File]:
    """A new file that lists its members in the order of their making; `content_of` gives its content.

    HDF5 makes it in memory and Python writes it: the HDF5 library does not survive a disk that is full. It refuses two
    files in memory of one name, as of two threads.
    """
    with h5py.File(uuid4().hex, "w", driver="core", backing_store=False, track_order=True, libver=LIBVER) as file:
        yield file


def content_of(file: h5py.File) -> bytes:
    """The content of a file in memory, which is complete."""
    file.flush()
    image: bytes = file.id.get_file_image()
    return image


def group_of(parent: h5py.Group, name: str) -> h5py.Group:
    """A new group that lists its members and attributes in the order of their making."""
    return parent.create_group(name, track_order=True)


def tell(about: h5py.Group | h5py.Dataset, told: Mapping[str, Any]) -> None:
    """Give a new group or array attributes that it has not got.

    As h5py's `attrs.update`, which looks for each whether it is there, and works its type out anew: texts and numbers,
    as most are, take half the time here.
    """
    for name, value in told.items():
        if type(value) not in _KINDS:
            about.attrs[name] = value
            continue
        stored, given, kind = _KINDS[type(value)]
        attribute = h5a.create(about.id, name.encode(), stored, _ALONE)
        attribute.write(np.array(value, kind), mtype=given)


def scale_of(group: h5py.Group, name: str, values: ArrayLike, long_name: str, unit: str = "") -> h5py.Dataset:
    """A dimension scale: the values along one axis of other arrays, which are given it as one of their `scales`.

    group: where it is made.
    name: of the dataset, and of the dimension.
    values: one for each index, shape (K,).
    long_name: what it is, in words.
    unit: "" for none.
    """
    dataset = array_of(group, name, values, [], long_name, unit=unit)
    dataset.make_scale(name)
    return dataset


def dimension_of(group: h5py.Group, name: str, size: int) -> h5py.Dataset:
    """A dimension without values, in netCDF's way: groups below inherit it as no coordinate.

    group: where it is made.
    name: of the dimension.
    size: of it.
    """
    dimension = group.create_dataset(name, data=np.zeros(size, ">f4"))
    dimension.make_scale(f"{NO_VARIABLE}{size:10d}")
    tell(dimension, {"long_name": f"the dimension {name}, without values"})
    return dimension


def array_of(
    group: h5py.Group, name: str, values: ArrayLike, scales: Sequence[h5py.Dataset], long_name: str, *, unit: str = ""
) -> h5py.Dataset:
    """A dataset with one scale for each of its dimensions.

    group: where it is made.
    name: of the dataset.
    values: a number or an array of any shape.
    scales: one for each dimension of the values; none for one that is a scale itself.
    long_name: what it is, in words.
    unit: "" for none.
    """
    array = np.asarray(values)
    if array.size and array.ndim and array.dtype.kind in "fiu":  # HDF5 has no check sum of texts or of single values
        dataset = group.create_dataset(name, data=array, chunks=_chunks(array), fletcher32=True)
    else:
        dataset = group.create_dataset(name, data=values)
    tell(dataset, {"long_name": long_name, **({"units": unit} if unit else {})})
    for axis, scale in enumerate(scales):
        dataset.dims[axis].attach_scale(scale)
    return dataset


def _chunks(array: np.ndarray) -> tuple[int, ...] | bool:
    """The whole array, which then needs no index of its parts; h5py's choice for one that is too large for that."""
    return array.shape if array.nbytes <= ONE_CHUNK else True


def bar_of(attributes: Mapping[str, Any]) -> dict[str, float]:
    """The attributes objective_error and objective_corrected of a result or of a mesh; NaN where there is no bar."""
    return {key: float(attributes.get(key, np.nan)) for key in ("objective_error", "objective_corrected")}


def accuracy_of(file: h5py.File) -> str:
    """Why the solution in a result file is not as accurate as was asked; "" where nothing is wrong."""
    if not file.attrs["solved"]:
        return ""
    solver, last = file["solver"].attrs, file["mesh"][str(len(file["mesh"]) - 1)].attrs
    bar = bar_of(file.attrs)["objective_error"] / (1 + abs(float(file.attrs["objective"])))
    return inaccurate(int(solver["unmet_count"]), solver["stopped"], last["relative_error"], bar)


def stored_meshes(group: h5py.Group) -> list[h5py.Group]:
    """The groups that hold the mesh of each phase: of one phase, the group /mesh/<k> itself."""
    return list(group["phase"].values()) if "phase" in group else [group]


def unit_of(dataset: h5py.Dataset) -> str:
    return printable(str(dataset.attrs.get("units", "")))
