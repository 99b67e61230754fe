"""`trajopt solve`: problem files -> results."""

from __future__ import annotations

import json
import logging
import shlex
import signal
import sys
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import typer

from .common import INTERRUPTED, NOT_SOLVED, command, load_all
from ..problems.errors import Mistake, SpecError

Files = Annotated[list[str], typer.Argument(metavar="FILE|NAME...", help="Problem files, or names from 'trajopt list'.")]
Output = Annotated[Path, typer.Option("-o", "--output", help="Result file; a folder if there are several problems.")]
Set = Annotated[list[str], typer.Option("--set", metavar="PATH=VALUE", help="Override a field of the problem file.")]
Method = Annotated[str, typer.Option("--method", help="Collocation method of every mesh of the schedule.")]
Segments = Annotated[int, typer.Option("--segments", min=1, help="Number of segments of the last mesh.")]
Tolerance = Annotated[float, typer.Option("--tol", help="IPOPT's tolerance on the last mesh.")]
Json = Annotated[bool, typer.Option("--json", help="Print one JSON object on one line for each problem.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Print every iteration.")]
Guess = Annotated[Path, typer.Option("--guess", metavar="RESULT", help="Start from the trajectories of this result.")]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file, whatever it holds.")]


@command
def solve(
    files: Files,
    output: Output = None,
    set_: Set = (),
    method: Method = None,
    segments: Segments = None,
    tol: Tolerance = None,
    guess: Guess = None,
    json_: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    force: Force = False,
) -> None:
    """Solve problems and write a result file for each.

    Example: trajopt solve cartpole --segments 50 --set parameters.u_max=15 -o swing.h5

    Without -o the result of FILE goes to <name of the file>.h5 in the current folder. All files are checked before the
    first is solved.
    """
    specs = load_all(files, overrides(set_, method, segments, tol))
    targets = _targets(specs, output)

    from ..results.store import check_target

    for spec, target in zip(specs, targets, strict=True):
        check_target(target, spec.name, force)
        for warning in () if quiet else spec.warnings:
            print(f"warning: {warning}", file=sys.stderr)
    _log_to_stderr(verbose)
    code = 0
    with _interruptible() as interrupted:
        for spec, target in zip(specs, targets, strict=True):
            solved = _solve_one(spec, target, guess, interrupted, json_, quiet, verbose)
            code = max(code, 0 if solved else NOT_SOLVED)
            if interrupted():
                code = INTERRUPTED
                break
    raise typer.Exit(code)


def overrides(set_, method: str | None, segments: int | None, tol: float | None) -> list[str]:
    """The shorthand options as overrides of the mesh schedule, after those of --set."""
    return [
        *set_,
        *([f"mesh.*.method={method}"] if method is not None else []),
        *([f"mesh.-1.segments={segments}"] if segments is not None else []),
        *([f"mesh.-1.tolerance={tol!r}"] if tol is not None else []),
    ]


def _targets(specs, output: Path | None) -> list[Path]:
    """Where each result goes; two problems may not go to one file."""
    names = [Path(spec.file).stem + ".h5" for spec in specs]
    if output is not None and len(specs) == 1 and not output.is_dir():
        return [output]
    if output is not None and not output.is_dir():
        raise SpecError(Mistake("-o", f"{output} is no folder, but there are {len(specs)} problems", "create the folder"))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise SpecError(Mistake("FILE", f"two of the problems would be written to {twice}", "solve them one by one with -o"))
    return [(output or Path()) / name for name in names]


def _solve_one(spec, target: Path, guess: Path | None, interrupted, as_json: bool, quiet: bool, verbose: bool) -> bool:
    """Solve, write, print; returns whether it is solved."""
    from .progress import live_line, print_iteration
    from ..problems.build import build
    from ..results.restart import guess_from
    from ..results.store import write
    from ..results.summary import summarize
    from ..transcription.outcome import Status
    from ..transcription.solve import solve as run
    from ..transcription.solve import steps

    problem, schedule = build(spec), steps(spec.mesh)
    accept = Status.ACCEPTABLE if spec.solver.accept == "acceptable" else Status.SOLVED
    with live_line(spec.name, len(schedule), wanted=not (quiet or verbose)) as line:
        progress = print_iteration if verbose else line
        start = guess_from(guess, problem) if guess else None
        solution = run(problem, schedule, spec.solver.options, start, progress, interrupted, accept)
    write(target, solution, spec.text, spec.model_dump_json(), shlex.join(["trajopt", *sys.argv[1:]]))
    summary = summarize(target)
    if as_json:
        print(json.dumps(summary))
    elif not quiet:
        from .table import print_summary

        print_summary(summary)
    if not solution.solved:
        cause = "; ".join(filter(None, [*summary["violations"][:1], summary["trouble"]]))
        print(f"not solved: {spec.name}: {summary['message']}" + (f" ({cause})" if cause else ""), file=sys.stderr)
    return solution.solved


@contextmanager
def _interruptible():
    """A function that tells whether Ctrl-C (or a scheduler's SIGTERM) has come; a second one ends at once."""
    seen = []

    def note(number, frame):
        if seen:
            raise KeyboardInterrupt
        seen.append(number)

    before = {number: signal.signal(number, note) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield lambda: bool(seen)
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def _log_to_stderr(verbose: bool) -> None:
    logging.basicConfig(stream=sys.stderr, format="%(message)s", level=logging.INFO if verbose else logging.WARNING)
