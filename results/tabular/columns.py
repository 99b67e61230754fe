"""The curves of results as columns, one row a time."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from decimal import Decimal
from pathlib import Path
from typing import NamedTuple

import numpy as np

from ...problems.errors import Mistake, SpecError
from ...transcription.solution.trajectory import Trajectory
from ..file.read import CURVE_KINDS, PhaseCurves, read
from ..file.reload import reload
from ..file.write_phase import functions_over

POINTS, DENSE = "points", "dense"

MAX_ROWS = 10_000_000
EXACT_DECIMALS = 22
"""Powers of ten up to this one are floats without rounding."""
ROUNDING = 1e-9
"""Of a step, or of all if that is shorter: the last time of an even grid is the final time if it is that near."""


class Column(NamedTuple):
    """values: (K,) numbers, or texts. unit: "" for none, and of texts."""

    unit: str
    values: np.ndarray


def stacked_table(paths: Sequence[Path], times: str | float) -> dict[str, Column]:
    """The curves of results, stacked: name -> column.

    paths: of results; of several, the first column tells the file.
    times: "points" of the mesh, "dense" for the fine grid of the file, or the step of an even grid, which the method's
        own interpolants are evaluated on; in the unit of time.

    Of several phases a column tells the phase, and one that a phase lacks is NaN there. A costate has the name of its
    state after costate_. Raises FileError if a file is no result, SpecError if an even grid has too many rows.
    """
    blocks = [block for path in paths for block in _blocks(path, times)]
    several = any(len(list(group)) > 1 for group in _by_file(blocks).values())
    found: dict[str, Column] = {}
    if len(paths) > 1:
        found["file"] = Column("", np.concatenate([np.full(len(b.time.values), b.file, object) for b in blocks]))
    if several:
        found["phase"] = Column("", np.concatenate([np.full(len(b.time.values), b.phase, object) for b in blocks]))
    found["time"] = Column(blocks[0].time.unit, np.concatenate([block.time.values for block in blocks]))
    for name in dict.fromkeys(name for block in blocks for name in block.curves):
        units = [block.curves[name].unit for block in blocks if name in block.curves]
        parts = [block.curves[name].values if name in block.curves else _nothing(block) for block in blocks]
        found[name] = Column(units[0], np.concatenate(parts))
    return found


class _Block(NamedTuple):
    """One phase of a result: its times and its curves by name."""

    file: str
    phase: str
    time: Column
    curves: Mapping[str, Column]


def _by_file(blocks: Sequence[_Block]) -> dict[str, list[_Block]]:
    files: dict[str, list[_Block]] = {}
    for block in blocks:
        files.setdefault(block.file, []).append(block)
    return files


def _nothing(block: _Block) -> np.ndarray:
    return np.full(len(block.time.values), np.nan)


def _blocks(path: Path, times: str | float) -> Iterator[_Block]:
    result = read(path)
    if isinstance(times, str):
        for phase in result.phases:
            yield _stored(str(path), phase, times)
        return
    rows = sum((phase.knots[-1] - phase.knots[0]) / times for phase in result.phases)
    if rows > MAX_ROWS:
        what = f"a step of {times:g} makes {rows:.3g} rows of {path}"
        raise SpecError(Mistake("--every", what, f"choose a longer one: there may be {MAX_ROWS:,} rows"))
    for trajectory in reload(path).trajectories:
        yield _even(str(path), trajectory, times)


def _stored(file: str, phase: PhaseCurves, where: str) -> _Block:
    """The curves as the file holds them, at the points or on the dense grid."""
    named = ((kind, name, curve) for kind in CURVE_KINDS for name, curve in phase.curves.get(kind, {}).items())
    curves = {_named(kind, name): Column(curve.unit, getattr(curve, where)) for kind, name, curve in named}
    time = phase.time if where == POINTS else phase.dense_time
    return _Block(file, phase.name, Column(phase.time_unit, time), curves)


def _even(file: str, trajectory: Trajectory, step: float) -> _Block:
    """The curves at the initial time, at steps after it and at the final time."""
    first, last, phase = trajectory.initial_time, trajectory.final_time, trajectory.phase
    count = int(np.floor((last - first) / step + ROUNDING))
    t = first + step * np.arange(count + 1)
    if (digits := max(_decimals(first), _decimals(step))) <= EXACT_DECIMALS:
        t = np.round(t, digits)
    near = ROUNDING * min(step, last - first)
    t = np.append(t, last) if last - t[-1] > near else np.append(t[:-1], last)
    s = (t - first) / (last - first) if last > first else np.zeros_like(t)
    sample = trajectory.at(np.clip(s, 0.0, 1.0))
    curves = {
        variable.name: Column(variable.unit, values)
        for variable, values in zip((*phase.states, *phase.inputs), (*sample.x, *sample.u), strict=True)
    }
    values = phase.arguments(t, sample.x, sample.u, trajectory.parameters)
    for _, name, curve, unit in functions_over(phase, values, t.shape):
        curves[name] = Column(unit, curve)
    if trajectory.costate is not None and sample.costate is not None:
        for state, dual in zip(phase.states, sample.costate, strict=True):
            curves[_named("costate", state.name)] = Column("", dual)
    return _Block(file, phase.name, Column(phase.time_unit, t), curves)


def _decimals(number: float) -> int:
    """Decimals of a number as it is written: 0.3 has one, and so have its multiples."""
    return max(0, -int(Decimal(repr(float(number))).as_tuple().exponent))


def _named(kind: str, name: str) -> str:
    return f"costate_{name}" if kind == "costate" else name
