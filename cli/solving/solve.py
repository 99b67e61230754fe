"""`trajopt solve`: problem files -> results."""

from __future__ import annotations

import logging
import os
import shlex
import sys
import tempfile
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import PIPES, make_folder
from ...problems.lean.records import dataclass
from ...transcription.loading import STDIN
from ..errors import NOT_SOLVED, TOLERANCE_MISSED, command
from ..options import Files, Force, Json, Method, Quiet, Segments, Set, overrides
from ..output.printing import one_line, print_json
from ..signals import Stop
from ..streams import native_output, piped_text, refuse_standard_output

if TYPE_CHECKING:
    from ...problems.problem import Guess
    from ...transcription.checked_files.ready import Ready
    from ...transcription.solution.solution import Solution

Output = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Result file, or a folder for them.")
]
Tolerance = Annotated[str | None, typer.Option("--tol", metavar="TOL", help="The engine's tolerance on the last mesh.")]
RefineTo = Annotated[
    str | None, typer.Option("--refine", metavar="TOL", help="Refine the mesh to this relative error.")
]
Accuracy = Annotated[
    str | None, typer.Option("--accuracy", metavar="TOL", help="Refine to this error bar of the objective.")
]
TimeLimit = Annotated[
    str | None, typer.Option("--time-limit", metavar="SECONDS", help="Stop by then; keep what is solved.")
]
Starts = Annotated[
    str | None, typer.Option("--starts", metavar="N", help="Also from N starts drawn within the bounds.")
]
Seed = Annotated[str | None, typer.Option("--seed", metavar="N", help="Of the drawn starts; 0 if not given.")]
Verbose = Annotated[bool, typer.Option("-v", "--verbose", help="Print every iteration.")]
GuessFile = Annotated[
    Path | None, typer.Option("--guess", metavar="RESULT", help="Start from the curves of this result.", readable=False)
]
Polish = Annotated[
    bool, typer.Option("--polish", help="Solve again in phases, one for each arc that the solution shows.")
]
Plot = Annotated[bool, typer.Option("--plot", help="Draw the result too, as 'trajopt plot' does.")]


@command
def solve(
    files: Files,
    *,
    output: Output = None,
    set_: Set = None,
    method: Method = None,
    segments: Segments = None,
    tol: Tolerance = None,
    refine: RefineTo = None,
    time_limit: TimeLimit = None,
    accuracy: Accuracy = None,
    guess: GuessFile = None,
    starts: Starts = None,
    seed: Seed = None,
    json_: Json = False,
    quiet: Quiet = False,
    verbose: Verbose = False,
    polish: Polish = False,
    plot: Plot = False,
    force: Force = False,
) -> None:
    """Solve problems and write a result file for each.

    Example: trajopt solve cartpole --set parameters.u_max=12 -o swing.h5

    Without -o the result of FILE goes to <name of the file>.h5 in the current folder. All files are checked before the
    first is solved. FILE may be - for standard input, whose result goes to stdin.h5.
    """
    if guess and (starts or seed):
        what = "with --guess there is one start, the result's"
        raise SpecError(Mistake("--starts" if starts else "--seed", what, "leave out one of the two options"))
    given = overrides(set_, method, segments, tol, refine, time_limit, accuracy, starts, seed)
    from ...transcription.checked_files.ready import ready_all  # NumPy, which `--help` needs not

    problems = ready_all(files, given, piped_text(files))
    logging.basicConfig(stream=sys.stderr, format="%(message)s", level=logging.WARNING)
    if verbose:
        logging.getLogger("trajopt").setLevel(logging.INFO)  # not cyipopt's, which tells of every call
    code = 0
    with Stop() as stop:
        jobs = _jobs(problems, _targets(problems, output), guess, force)
        if not quiet:
            _warn(jobs, guess)
        for job in jobs:
            solution = _solved(job, stop, quiet, verbose)
            path = _kept(job, solution)
            if polish and solution.solved:
                better, solution = _polished(job, solution, stop, quiet, verbose)
                path = _kept(better, solution)
            if json_ or not (quiet and solution.solved):
                _tell(path, json_, quiet)
            if plot:
                from ..result_files.plot import draw_trajectory

                print(f"picture: {draw_trajectory(path, force)}", file=sys.stderr)
            if stop() and (job is not jobs[-1] or not solution.solved or solution.stopped):
                raise typer.Exit(stop.exit_code)  # a signal after the last iteration of the last one took nothing away
            code = NOT_SOLVED if not solution.solved else code or (TOLERANCE_MISSED if solution.inaccurate else 0)
    raise typer.Exit(code)


def _warn(jobs: list[_Job], guess: Path | None) -> None:
    """What is odd in the files, and what the result to start from lacks; each once."""
    from ...results.file.guess import lacking

    odd = [warning for job in jobs for warning in job.ready.warnings]
    missing = [warning for job in jobs for warning in lacking(guess, job.ready.problems[0])] if guess else []
    for warning in dict.fromkeys([*odd, *missing]):
        print(f"warning: {one_line(str(warning))}", file=sys.stderr)


@dataclass(frozen=True)
class _Job:
    ready: Ready
    target: Path
    guess: list[Guess] | None
    force: bool


def _targets(problems: list[Ready], output: str | None) -> list[Path]:
    """Where each result goes; two problems may not go to one file."""
    names = [
        "stdin.h5" if own.file == STDIN or own.file.startswith(PIPES) else Path(own.file).stem + ".h5"
        for own in problems
    ]
    refuse_standard_output(output, "a result is an HDF5 file", "print numbers with --json or trajopt table FILE -o -")
    if output is not None and output.endswith(os.sep):
        make_folder(Path(output))
    if output is not None and not Path(output).is_dir():
        if len(problems) == 1:
            return [Path(output)]
        what = f"this is no folder, but there are {len(problems)} problems"
        raise SpecError(Mistake(f"-o {output}", what, f"write -o {output}/ for a folder, which is made"))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise SpecError(Mistake(twice, "two of the problems would go to this file", "solve one of them with -o"))
    return [Path(output or "") / name for name in names]


def _jobs(problems: list[Ready], targets: list[Path], guess: Path | None, force: bool) -> list[_Job]:
    """All that can go wrong with result files goes wrong here, before the first problem is solved."""
    from ...results.file.guess import guess_from
    from ...results.file.write import check_target

    jobs = []
    for own, target in zip(problems, targets, strict=True):
        check_target(target, own.name, force)
        jobs.append(_Job(own, target, guess_from(guess, own.problems[0]) if guess else None, force))
    return jobs


def _solved(job: _Job, stop: Callable[[], bool], quiet: bool, verbose: bool) -> Solution:
    from ..output.progress import live_line, print_iteration

    with native_output(2), live_line(job.ready.name, wanted=not (quiet or verbose)) as line:
        return job.ready.solve(guess=job.guess, progress=print_iteration if verbose else line, stop=stop)


def _polished(
    job: _Job, solution: Solution, stop: Callable[[], bool], quiet: bool, verbose: bool
) -> tuple[_Job, Solution]:
    """The solution in phases by its arcs, and the job with their file; both as they are where that is no better."""
    from ...results.polish.polish import polish
    from ...transcription.checked_files.ready import ready
    from ..output.progress import live_line, print_iteration

    own = job.ready
    with native_output(2), live_line(own.name, wanted=not (quiet or verbose)) as line:
        found = polish(own.spec(), solution, print_iteration if verbose else line, stop)
    better = ready(found.spec, own.problems)
    return replace(job, ready=replace(better, overrides=own.overrides)), found.solution


def _kept(job: _Job, solution: Solution) -> Path:
    """Write the result, and tell where: beside an earlier solution that it should not replace.

    If its place has gone since the start, it goes elsewhere, since a solve can take hours.
    """
    from ...results.file.write import place_for, write

    own = job.ready
    place = job.target if job.force else place_for(job.target, own.name, solution.solved)
    if place != job.target:
        kept = f"{job.target} holds a solution and is kept (--force replaces it); this result is in {place}"
        print(f"note: {one_line(kept)}", file=sys.stderr)
    told = own.text, own.full, shlex.join(["trajopt", *sys.argv[1:]]), own.overrides
    try:
        write(place, solution, *told)
    except FileError as error:
        (mistake,) = error.mistakes
        try:
            rescued = Path(tempfile.mkdtemp(prefix="trajopt-")) / place.name
            write(rescued, solution, *told)
        except (FileError, OSError) as again:
            why = again.strerror if isinstance(again, OSError) else again.mistakes[0].what
            what = f"{mistake.what}, and no other place was found for it: in {tempfile.gettempdir()} {why}"
            raise FileError(replace(mistake, what=what)) from error
        raise FileError(replace(mistake, remedy=f"the result is in {rescued}, move it from there")) from error
    return place


def _tell(path: Path, as_json: bool, quiet: bool) -> None:
    """Print what the result file holds; a failure also goes to standard error if the table is not seen there."""
    from ...results.file.summary import causes, summarize
    from ..output.table import print_summary

    summary = summarize(path)
    if as_json:
        print_json(summary)
    elif not quiet:
        print_summary(summary)
    if not summary["solved"] and (as_json or quiet or not sys.stdout.isatty()):
        why_not = causes(summary["trouble"], summary["violations"], summary["involved"])[:1]
        relief = [f"this would do: {own}" for own in summary["relief"][:1]]
        why = "; ".join([summary["message"], *relief, *why_not, summary["remedy"]])
        print(f"not solved: {one_line(summary['problem'])}: {one_line(why)}", file=sys.stderr)
