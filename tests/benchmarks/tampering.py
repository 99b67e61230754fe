"""Good results made bad: each change goes into a copy of a result file, the arrays that people read included.

A change is one of the solver's point z or of its multipliers; then the curves of the file are written anew from it, so
that the file agrees with itself. What a problem has no room for (a shift of a control that is constant, the sign of a
costate that is 0) is no change.
"""

from __future__ import annotations

import shutil
from collections.abc import Callable
from functools import partial
from pathlib import Path

import h5py
import numpy as np

from trajopt.results.file.reload import Reloaded, reload
from trajopt.transcription.constraint_kinds import DEFECT

SOME = 1e-3  # of its range, or of 1 + its size: a control that a change alters by less is as it was
NONE = 1e-4  # of the largest costate: what is smaller is zero

Change = Callable[[Reloaded, np.ndarray, np.ndarray], bool]
"""Changes z and the multipliers y in place; whether it has done anything."""


def tampered(change: Change, source: Path, target: Path) -> bool:
    """A copy of a result with a change, if there is room for it."""
    result = reload(source)
    z, y = result.outcome.z.copy(), result.outcome.y.copy()
    if not change(result, z, y):
        return False
    shutil.copy(source, target)
    with h5py.File(target, "r+") as file:
        file["solver/z"][...], file["solver/y"][...] = z, y
    _renew(target)
    return True


def _renew(path: Path) -> None:
    """Write the curves of a file anew from its z and its multipliers, and the objective too."""
    result = reload(path)
    with h5py.File(path, "r+") as file:
        file.attrs["objective"] = result.problem.sense * result.nlp.objective(result.outcome.z)
        for own in result.trajectories:
            group, n = file[f"phase/{own.phase.name}"], len(own.phase.controls)
            costate = None if own.costate is None else own.point_costate
            for where, x, u, p in (
                ("points", own.x, own.u, costate),
                ("dense", own.dense.x, own.dense.u, own.dense.costate),
            ):
                rows = [("state", own.phase.states, x), ("control", own.phase.controls, u[:n])]
                rows += [
                    ("algebraic", own.phase.algebraic, u[n:]),
                    *([("costate", own.phase.states, p)] if p is not None else []),
                ]
                for kind, variables, values in rows:
                    for variable, curve in zip(variables, values, strict=True):
                        group[f"{where}/{kind}/{variable.name}"][...] = curve


def _control(result: Reloaded) -> tuple[np.ndarray, np.ndarray] | None:
    """The points and the places in z of the control that varies most, of the first phase that has one."""
    for layout, own in zip(result.transcription.phases, result.trajectories, strict=True):
        rows = range(len(own.phase.controls))
        spans = [np.ptp(own.u[i, layout.u[i] >= 0]) for i in rows]
        if spans and max(spans) > 0:
            place = layout.u[int(np.argmax(spans))]
            return np.flatnonzero(place >= 0), place[place >= 0]
    return None


def scale_control(result: Reloaded, z: np.ndarray, y: np.ndarray) -> bool:
    found = _control(result)
    if found is None:
        return False
    z[found[1]] *= 1.01
    return True


def shift_control(result: Reloaded, z: np.ndarray, y: np.ndarray) -> bool:
    """By one segment, later; the first segment keeps its own."""
    found = _control(result)
    if found is None:
        return False
    own = result.trajectories[0]
    t = own.times[found[0]] if len(own.times) > found[0].max() else found[0].astype(float)
    old = z[found[1]].copy()
    z[found[1]] = np.interp(t - own.h.mean(), t, old)
    return bool(np.abs(z[found[1]] - old).max() > SOME * (1 + np.abs(old).max()))


def offset_state(result: Reloaded, z: np.ndarray, y: np.ndarray) -> bool:
    layout, own = result.transcription.phases[0], result.trajectories[0]
    i = int(np.argmax(np.ptp(own.x, axis=1)))
    place = layout.x[i][layout.x[i] >= 0]
    z[place] += 1e-3 * np.ptp(own.x[i])
    return len(place) > 0 and np.ptp(own.x[i]) > 0


def move_final_state(result: Reloaded, z: np.ndarray, y: np.ndarray) -> bool:
    layout, own = result.transcription.phases[-1], result.trajectories[-1]
    ends = layout.x[:, -1]
    if not (ends >= 0).any():
        return False
    i = int(np.argmax(np.where(ends >= 0, np.ptp(own.x, axis=1), -1.0)))
    z[ends[i]] += 1e-3 * (1 + abs(z[ends[i]]))
    return True


def flip_costate(result: Reloaded, z: np.ndarray, y: np.ndarray) -> bool:
    """The defects' multipliers of the state whose costate is worth most, and with them the costate."""
    own = result.trajectories[0]
    if own.costate is None or not len(own.phase.controls):
        return False
    worth = np.abs(own.costate).max(axis=1) * np.ptp(own.dense.x, axis=1)
    name = own.phase.states[int(np.argmax(worth))].name
    if not worth.max() > NONE * (1 + abs(result.objective)):
        return False
    for family in result.transcription.families:
        if (family.kind, family.phase, family.name) == (DEFECT, own.phase.name, name):
            y[family.rows(result.nlp)] *= -1
    return bool((y != result.outcome.y).any())


def change_objective(source: Path, target: Path) -> bool:
    """By 1e-4 of it, in the file only."""
    shutil.copy(source, target)
    with h5py.File(target, "r+") as file:
        before = float(file.attrs["objective"])
        file.attrs["objective"] = before * (1 + 1e-4)
    return abs(before) > 1e-3


def flip_stored_costate(source: Path, target: Path) -> bool:
    """The arrays that people read, not the multipliers."""
    shutil.copy(source, target)
    found = False
    with h5py.File(target, "r+") as file:
        for group in file["phase"].values():
            for where in ("points", "dense"):
                for curve in group[f"{where}/costate"].values():
                    found |= bool(np.abs(curve[...]).max() > NONE)
                    curve[...] *= -1
    return found


KINDS: dict[str, Callable[[Path, Path], bool]] = {
    "control scaled by 1.01": partial(tampered, scale_control),
    "control shifted by one segment": partial(tampered, shift_control),
    "state offset by 1e-3 of its range": partial(tampered, offset_state),
    "final value of a state moved by 1e-3": partial(tampered, move_final_state),
    "costate sign flipped": partial(tampered, flip_costate),
    "stored costates' sign flipped": flip_stored_costate,
    "objective changed by 1e-4": change_objective,
}
"""What was done -> how; each takes a good result and where the bad one goes, and says whether there was room for it."""
