"""Solve and verify shipped problems, several at a time, each in a process of one thread."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from dataclasses import replace
from math import inf
from pathlib import Path
from typing import Any

from ...problems.build import build_all
from ...problems.catalog import shipped
from ...problems.errors import Mistake, SpecError, TrajoptError
from ...problems.load import load
from ...problems.schema.spec import Spec
from ...problems.text import did_you_mean
from ...transcription.continuation import solve_spec
from ...transcription.engines.watch import Limit
from ...transcription.solution.solution import Solution
from ..file.write import check_target, write
from ..polish.polish import polish
from ..sweep.engines import LocalEngine
from ..verify import verify
from .rows import EXCLUDED, FINE, SHORT, SLOW, Finer, Row, row_of

MOST_SECONDS = 60.0
"""Of the process's own time, whatever else the machine does: for each solve that is to tell all digits of a reference.
Those that tell them take 30 s at most."""


def problems(only: Sequence[str], fast: bool) -> list[str]:
    """The names of the shipped problems that are meant, all of them if none is named; fast: without the slow ones.

    Raises SpecError for names that no shipped problem has, and if none of those named is fast.
    """
    known = shipped()
    unknown = [name for name in dict.fromkeys(only) if name not in known]
    if unknown:
        remedy = "see 'trajopt list'"
        raise SpecError(
            Mistake(f"--only {name}", "there is no such shipped problem", did_you_mean(name, known, otherwise=remedy))
            for name in unknown
        )
    meant = [name for name in known if (not only or name in only) and not (fast and name in SLOW)]
    if not meant:
        raise SpecError(Mistake("--fast", f"{', '.join(only)} takes long, so nothing is left", "leave out --fast"))
    return meant


def solve_one(name: str, folder: Path, command: str = "", verified: bool = True, finer: bool = True) -> Row:
    """Solve a shipped problem as its file says, and verify it; and for more digits, if its objective and the reference
    do not agree in all of them.

    name: of the problem.
    folder: where its result file goes, as NAME.h5.
    command: what the user typed, for the result file.
    verified: whether the checks of `verify` are made, which often take longer than the solve.
    finer: whether these other solves are made.

    Raises FileError if the file cannot be written.
    """
    spec, path = load(shipped()[name]), folder / f"{name}.h5"
    began = time.perf_counter()
    solution = solve_spec(spec, build_all(spec))
    solved = time.perf_counter()
    write(path, solution, spec.text, spec.model_dump_json(), command)
    checks = verify(path) if verified else []
    row = row_of(name, spec, solution, checks, (solved - began, time.perf_counter() - solved))
    wanted = finer and row.bar is not None and row.complete is False and not (spec.static or spec.discrete)
    return finest(row, spec, solution) if wanted else row


def finest(row: Row, spec: Spec, solution: Solution, seconds: float = MOST_SECONDS) -> Row:
    """The row with a solve that agrees in all digits of the reference, or excludes it: by phases, one for each arc, or
    by a smaller error bar.

    row: of the solution.
    spec: of the problem.
    solution: that the default leads to.
    seconds: of this process, for each of the two.
    """
    new = polish(spec, solution, stop=_limit(seconds)).solution
    polished = replace(row, finer=_told("--polish", new, solution))
    if polished.standing in (FINE, EXCLUDED):
        return polished
    accuracy = f"{row.accuracy_of_digits:.0e}"
    spec = load(shipped()[row.name], [f"refine.objective={accuracy}"])
    new = solve_spec(spec, build_all(spec), stop=_limit(seconds))
    refined = replace(row, finer=_told(f"--accuracy {accuracy}", new, solution))
    found = [own for own in (refined, polished) if own.finer]
    return min(found, key=lambda own: (own.standing == SHORT, own.finer.bar if own.finer else inf), default=row)


def _limit(seconds: float) -> Callable[[], bool]:
    return Limit(seconds, None, time.process_time).reached


def _told(option: str, finer: Solution, solution: Solution) -> Finer | None:
    """What came of an option; None if it is no better."""
    bar = finer.objective_error.bar
    if not finer.solved or not bar < solution.objective_error.bar:
        return None
    return Finer(option, float(finer.objective), float(bar))


def solve_library(
    names: Sequence[str],
    folder: Path,
    *,
    processes: int,
    prepare: Callable[[Any], None],
    command: str = "",
    progress: Callable[[str], None] = lambda text: None,
) -> list[Row]:
    """Solve and verify shipped problems; what fails is a row as well.

    names: of the problems.
    folder: where the result files go.
    processes: how many solve at a time.
    prepare: called in each process first, with a flag that asks it to stop.
    command: what the user typed, for the result files.
    progress: called with a text after each problem.

    Raises FileError if a file cannot be written, or if one is there that holds something else.
    """
    for name in names:
        check_target(folder / f"{name}.h5", load(shipped()[name]).name)
    engine = LocalEngine(min(processes, max(len(names), 1)), prepare)
    waiting = sorted(
        names, key=lambda name: name not in SLOW
    )  # the longest first, so that no process is idle at the end
    running: dict[Future[Row], str] = {}
    rows: dict[str, Row] = {}
    try:
        while waiting or running:
            while waiting and len(running) < engine.capacity:
                name = waiting.pop(0)
                running[engine.begin(solve_one, name, folder, command)] = name
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                name = running.pop(future)
                rows[name] = _row(name, future)
                progress(f"{len(rows)} of {len(names)}, {name} is done")
    finally:
        engine.close()
    return [rows[name] for name in names]


def _row(name: str, future: Future[Row]) -> Row:
    """What a process gives back; a process that has died, or a bug of ours, is a problem that is not solved."""
    error = future.exception()
    if isinstance(error, TrajoptError):
        raise error
    return future.result() if error is None else Row(name, message=f"{type(error).__name__}: {error}")
