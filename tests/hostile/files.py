"""Small good results, one for each kind of problem and method, and all that is made bad of them."""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

import h5py

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.file.write import write
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

from . import content, objects

TINY = """
trajopt: 1
name: tiny
time: {initial: 0, final: {lower: 0.5, upper: 2}}
states: {x: {rate: v, initial: 0, final: 1, unit: m}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -10, upper: 10, unit: N}}
objective: {minimize: {integral: u**2 + 1}}
reference: {objective: 6.9, tolerance: 10, source: nobody}
mesh: [{method: hermite-simpson, segments: 4}]
"""

RESULTS = {
    "collocation": ("", []),
    "shooting": ("", ["mesh=[{method: runge-kutta-4, segments: 4, substeps: 2}]"]),
    "degrees": ("", ["mesh=[{method: gauss, segments: 3, degree: 3}]"]),
    "refined": ("cartpole", ["mesh=[{method: trapezoid, segments: 4}]", "refine.tolerance=0.05"]),
    "failed": ("cartpole", ["mesh.-1.segments=3", "solver.max_iter=2"]),
    "nonsmooth": ("block_move_min_work", ["mesh.-1.segments=3"]),
    "static": ("shot_put", ["mesh.-1.segments=3"]),
    "biped": ("biped", ["mesh.-1.segments=3"]),
    "phases": (
        "schwartz_two_phase",
        [
            "phases.weak.mesh=[{method: radau, segments: 3, degree: 3}]",
            "phases.strong.mesh=[{method: runge-kutta-4, segments: 3}]",
            "refine=",
            "expressions={speed: {value: 2*x2, unit: m}}",
        ],
    ),
    "measured": ("enzyme_progress_curves", ["refine="]),
    "algebraic": ("pendulum_dae", ["mesh.-1.segments=4", "solver.max_iter=3"]),
}
"""Name -> the shipped problem, "" for TINY, and overrides."""

OLD = "old"  # a result of the structures of HDF5 without check sums, as older versions of trajopt wrote them


class Bad(NamedTuple):
    """A file to be made: of which good one, what is wrong with it, and the function that makes it so in a copy."""

    source: Path
    name: str
    damage: Callable[[Path], None]


def good_results(folder: Path, names: Sequence[str] = (*RESULTS, OLD)) -> list[Path]:
    """Solve and write them, once for a folder."""
    for name in names:
        if name != OLD and not (folder / f"{name}.h5").exists():
            shipped_name, given = RESULTS[name]
            spec = load(shipped()[shipped_name], given) if shipped_name else load_text(TINY, "tiny.yaml", given)
            solution = solve(build_all(spec), schedule_of(spec), settings_of(spec))
            write(folder / f"{name}.h5", solution, spec.text, spec.model_dump_json(), f"trajopt solve {name}")
    if OLD in names:
        _without_sums(folder / "collocation.h5", folder / f"{OLD}.h5")
    return [folder / f"{name}.h5" for name in names]


def _without_sums(source: Path, target: Path) -> None:
    with h5py.File(source) as file, h5py.File(target, "w", libver="earliest", track_order=True) as old:
        for name in file:
            file.copy(name, old)
        old.attrs.update(file.attrs)

        def plain(name: str, own: h5py.Dataset | h5py.Group) -> None:
            if isinstance(own, h5py.Dataset) and own.fletcher32:
                names.append(name)

        names: list[str] = []
        old.visititems(plain)
        for name in names:
            values, attributes = old[name][()], {"units": old[name].attrs.get("units")}
            del old[name]
            old[name] = values
            old[name].attrs.update({key: value for key, value in attributes.items() if value is not None})


def bad_files(sources: Sequence[Path], count: int, seed: int) -> Iterator[Bad]:
    """So many bad files: a fifth has damaged bytes, a tenth another problem in it, the others a damaged object.

    sources: good results.
    count: of all.
    seed: of the choice.

    A count that exceeds all objects, attributes and kinds gives each of these once.
    """
    rng = random.Random(seed)
    structure = [Bad(source, *own) for source in sources for own in objects.damages(source)]
    rng.shuffle(structure)
    yield from structure[: round(0.7 * count)]
    for k in range(round(0.2 * count)):
        kind = rng.choice(list(content.BYTES))
        yield Bad(rng.choice(sources), f"{kind} {k}", content.BYTES[kind](rng))
    for k in range(round(0.1 * count)):
        yield Bad(rng.choice(sources), f"problem {k}", content.problems(rng))


def always(source: Path) -> Iterator[Bad]:
    """What is tried in each campaign: files that are no results, and texts that are no problem."""
    for name, damage in content.FOREIGN.items():
        yield Bad(source, f"foreign: {name}", damage)
    for name, text in content.TEXTS.items():
        yield Bad(source, f"text: {name}", content.with_problem(lambda _, text=text: text))
