"""sweep.h5: the records of a sweep as arrays over what was swept, for xarray and every netCDF-4 tool.

A grid has one dimension for each axis, named after the last part of its path (u_max of parameters.u_max) where no other
axis or array has that name, with its values as coordinates. Other designs have the one dimension `case`, along which
the swept values are coordinates. A case that has not ended is NaN, -1 iterations, and status "missing".
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from ...problems.files import write_whole
from ...problems.yaml.document import value_of
from ..file.arrays import array_of, content_of, file_in_memory, scale_of
from ..file.arrays import texts as texts_of
from .plan import GRID, Plan
from .tables import SCALARS, TEXTS, Record, column, groups


def write_arrays(path: Path, plan: Plan, records: Mapping[int, Record], about: Mapping[str, Any]) -> None:
    """Write the file. Raises FileError.

    path: of the HDF5 file.
    plan: the cases.
    records: by the number of the case.
    about: attributes; "units" maps the names of states, parameters and "time" to theirs.
    """
    units = about.get("units", {})
    with file_in_memory() as file:
        file.attrs.update({key: value for key, value in about.items() if key != "units"})
        named = groups(records.values())
        pairs = [(group, name) for group, names in named.items() for name in names]
        taken = [*SCALARS, *TEXTS, "solved", "case", *(column(*pair) for pair in pairs)]
        scales = _scales(file, plan, taken, units)
        for name, words in SCALARS.items():
            unit = units.get("time", "") if name == "final_time" else "s" if name == "seconds" else ""
            values = _filled(plan, {n: r[name] for n, r in records.items()}, name)
            array_of(file, name, values, scales, words, unit=unit)
        for group, name in pairs:
            found = {n: r[group].get(name) for n, r in records.items()}
            words = f"{name} that was found" if group == "parameters" else f"{group} value of {name}"
            array_of(file, column(group, name), _filled(plan, found), scales, words, unit=units.get(name, ""))
        solved = np.array([bool(records.get(n, {}).get("solved")) for n in range(len(plan))], np.int8)
        array_of(file, "solved", solved.reshape(plan.shape), scales, "whether the case is solved, 1 or 0")
        for name, words in TEXTS.items():
            texts = [records[n][name] if n in records else "missing" * (name == "status") for n in range(len(plan))]
            array_of(file, name, texts_of(texts).reshape(plan.shape), scales, words)
        image = content_of(file)
    write_whole(path, image)


def dimensions(paths: Sequence[str], taken: Sequence[str]) -> list[str]:
    """A short name for each path, unlike all others and those that are taken."""
    last = [path.rpartition(".")[2] for path in paths]
    short = [
        name if last.count(name) == 1 and name not in taken else path for name, path in zip(last, paths, strict=True)
    ]
    return [name.replace("/", "_") for name in short]


def _scales(file: h5py.File, plan: Plan, taken: Sequence[str], units: Mapping[str, str]) -> list[h5py.Dataset]:
    """The dimensions of all arrays, and the swept values as coordinates."""
    names = dimensions(plan.paths, taken)
    if plan.design == GRID:
        return [
            scale_of(file, name, _coordinates(axis.values), axis.path, _unit(axis.path, units))
            for name, axis in zip(names, plan.axes, strict=True)
        ]
    case = scale_of(file, "case", np.arange(len(plan)), "number of the case, from 0")
    for name, axis in zip(names, plan.axes, strict=True):
        array_of(file, name, _coordinates(axis.values), [case], axis.path, unit=_unit(axis.path, units))
    file.attrs["coordinates"] = " ".join(names)
    return [case]


def _unit(path: str, units: Mapping[str, str]) -> str:
    section, _, name = path.partition(".")
    return units.get(name, "") if section == "parameters" else ""


def _coordinates(values: Sequence[str]) -> np.ndarray:
    """Numbers where all values are, else texts; shape (K,)."""
    plain = [value_of(value, "") for value in values]
    if all(isinstance(value, int | float) and not isinstance(value, bool) for value in plain):
        return np.array(plain)
    return texts_of(values)


def _filled(plan: Plan, values: Mapping[int, float | None], name: str = "") -> np.ndarray:
    """Values by case as an array of the plan's shape, where those that are missing are NaN, or -1 in whole numbers."""
    array = np.full(len(plan), -1) if name == "iterations" else np.full(len(plan), np.nan)
    for number, value in values.items():
        if value is not None:
            array[number] = value
    return array.reshape(plan.shape)
