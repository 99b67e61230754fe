"""Many solves in one process: memory, file handles and threads must not grow with their number."""

from __future__ import annotations

import gc
import os
import threading
from collections.abc import Iterator
from pathlib import Path

import trajopt
from trajopt.problems.errors import SpecError

BLOCK = """
trajopt: 1
name: block
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u - RATE, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 8}]
"""
MARKS = (10, 50, 100, 200, 300, 500, 700, 1000, 1500, 2000)
"""Numbers of solves after which it is looked."""
FORMS = 20
SHOOTING = "mesh=[{method: runge-kutta-4, segments: 10}]"
RADAU = "mesh=[{method: radau, degree: 4, segments: 6}]"


def _with_other_numbers(k: int, folder: Path) -> None:
    """The next case of a sweep: its program is kept."""
    _kept(trajopt.solve(trajopt.load("cartpole", {"parameters.u_max": 12 + 0.01 * k, "mesh.-1.segments": 10})), folder)


def _of_another_form(k: int, folder: Path) -> None:
    """Another expression is differentiated and compiled; its code is kept, so that there are FORMS of them."""
    k %= FORMS
    trajopt.solve(trajopt.load(BLOCK.replace("RATE", f"sin({k + 1}*x)/{k + 1} - 0.1*v**{2 + k % 5}")))


def _refined(k: int, folder: Path) -> None:
    trajopt.solve(trajopt.load("block_move_min_work_smooth", {"refine.tolerance": 1e-3, "mesh.-1.segments": 10}))


def _failed(k: int, folder: Path) -> None:
    assert not trajopt.solve(trajopt.load("cartpole", {"solver.max_iter": 2, "mesh.-1.segments": 5})).solved


def _shot(k: int, folder: Path) -> None:
    trajopt.solve(trajopt.load("block_move_min_force", [SHOOTING]))


def _of_phases(k: int, folder: Path) -> None:
    _kept(trajopt.solve(trajopt.load("block_move_three_phases")), folder)


def _of_high_degree(k: int, folder: Path) -> None:
    trajopt.solve(trajopt.load("cartpole", [RADAU]))


def _refused(k: int, folder: Path) -> None:
    try:
        trajopt.load(BLOCK.replace("RATE", f"w{k}"))
    except SpecError:
        return
    raise AssertionError("a name that is unknown was taken")


def _kept(solution: trajopt.Solution, folder: Path) -> None:
    """Written, and read again."""
    solution.save(folder / "life.h5", force=True)
    trajopt.read(folder / "life.h5")


WORK = (_with_other_numbers, _of_another_form, _failed, _refined, _shot, _of_phases, _of_high_degree, _refused)
"""One after the other; each is a solve, and the last a file that is refused."""


def looked() -> dict[str, int]:
    """Resident memory in MB, open file handles, threads of the process and of Python."""
    status = dict(line.split(":", 1) for line in Path("/proc/self/status").read_text().splitlines())
    return {
        "MB": int(status["VmRSS"].split()[0]) // 1024,
        "handles": len(os.listdir("/proc/self/fd")),
        "threads": int(status["Threads"]),
        "of Python": threading.active_count(),
    }


def life(count: int, folder: Path) -> Iterator[tuple[int, dict[str, int]]]:
    """(solves so far, what was looked at) at each of MARKS and at the end."""
    for k in range(count):
        WORK[k % len(WORK)](k // len(WORK), folder)
        if k + 1 in MARKS or k + 1 == count:
            gc.collect()
            yield k + 1, looked()


def grows(marks: dict[int, dict[str, int]]) -> list[str]:
    """What there is more of at the end than when half of the solves were done.

    Caches are full by then: memory may grow by a twentieth in the second half, and nothing else at all.
    """
    end = max(marks)
    half = max((k for k in marks if k <= end / 2), default=end)
    more = {"MB": 1.05 * marks[half]["MB"]}
    return [what for what, value in marks[end].items() if value > more.get(what, marks[half][what])]
