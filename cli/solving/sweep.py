"""`trajopt sweep`: one problem file, solved for many values of its fields."""

from __future__ import annotations

import shlex
import sys
import time
from collections.abc import Callable, Mapping
from enum import StrEnum
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...problems.lean.records import dataclass
from ...transcription.loading import STDIN, build_checked, load_all, load_yaml
from ..errors import NOT_SOLVED, USER_MISTAKE, command
from ..options import Json, Method, Quiet, Segments, Set, overrides
from ..output.printing import one_line, print_json
from ..output.sweeping import Tally, print_sweep, watched
from ..signals import Stop
from ..streams import piped_text, refuse_standard_output
from .cases import Asked, planned_cases, processes_of
from .cases import shard as shard_of
from .workers import prepare_workers

if TYPE_CHECKING:
    from ...problems.problem import Problem
    from ...problems.schema.spec import Spec
    from ...results.sweep.engines import Engine
    from ...results.sweep.plan import Plan
    from ...results.sweep.store import Store

MAX_TOLD = 10
"""Mistakes of cases that are told one by one."""


class Keep(StrEnum):
    """What is kept of each case."""

    small = "small"
    full = "full"


_FILE = Annotated[str, typer.Argument(metavar="FILE|NAME", help="Problem file, name, or - for standard input.")]
_OVER = "Field, and its values: START:STOP:COUNT, log:START:STOP:COUNT or A,B,C."
Over = Annotated[list[str] | None, typer.Option("--over", metavar="PATH=VALUES", help=_OVER)]
Zip = Annotated[bool, typer.Option("--zip", help="Go through the axes together, instead of solving all combinations.")]
List = Annotated[Path | None, typer.Option("--list", metavar="CSV", help="Table: paths above, one case on each line.")]
Sample = Annotated[str | None, typer.Option("--sample", metavar="N", help="Latin hypercube over the ranges of --over.")]
Seed = Annotated[str | None, typer.Option("--seed", metavar="S", help="Of the sample; default 0.")]
Output = Annotated[
    Path | None, typer.Option("-o", "--output", metavar="FOLDER", help="Default: NAME-sweep in the current folder.")
]
KeepOption = Annotated[Keep, typer.Option("--keep", help="Keep the full result file of each case as well.")]
Jobs = Annotated[str | None, typer.Option("--jobs", "-j", metavar="N", help="Processes; default one for each CPU.")]
Shard = Annotated[str | None, typer.Option("--shard", metavar="I/N", help="Solve every N-th case, from the I-th.")]
Scheduler = Annotated[
    str | None, typer.Option("--scheduler", metavar="ADDRESS", help="Solve on this Dask cluster: tcp://host:8786.")
]
Chain = Annotated[
    bool | None, typer.Option("--chain/--no-chain", help="Start from the case before, or from the guess (default).")
]
Resume = Annotated[bool, typer.Option("--resume", help="Go on with a sweep that must be there; it is without, too.")]
StartAnew = Annotated[bool, typer.Option("--force", help="Start anew: throw away the sweep that is in the folder.")]


@command
def sweep(
    file: _FILE,
    *,
    over: Over = None,
    zip_: Zip = False,
    list_: List = None,
    sample: Sample = None,
    seed: Seed = None,
    output: Output = None,
    set_: Set = None,
    method: Method = None,
    segments: Segments = None,
    keep: KeepOption = Keep.small,
    jobs: Jobs = None,
    shard: Shard = None,
    scheduler: Scheduler = None,
    chain: Chain = None,
    resume: Resume = False,
    force: StartAnew = False,
    json_: Json = False,
    quiet: Quiet = False,
) -> None:
    """Solve a problem for many values of its fields.

    Example: trajopt sweep cartpole --over parameters.u_max=8:20:25 --over mesh.0.segments=25,50

    Each --over is an axis of a grid. FOLDER gets index.csv (a line for each case) and sweep.h5 (arrays over the axes).
    The same command again solves what is missing or failed. Exit code 1 if a case is not solved.
    """
    from ...results.sweep.store import Store, about

    refuse_standard_output(output, "a sweep is a folder", "print its table with --json")
    given = overrides(set_, method, segments)
    (spec,) = load_all([file], given, piped_text([file]))
    plan, chained = planned_cases(Asked(over, zip_, list_, sample, seed, chain), spec, given)
    part = shard_of(shard, chained, force)
    processes = processes_of(jobs)
    problem = _checked(plan, spec, given)
    name = "stdin" if spec.file == STDIN else Path(spec.file).stem
    store = Store(output or Path(f"{name}-sweep"), plan, part)
    with Stop() as stop:
        store.open(about(plan, spec.text, spec.file, given, chained), force, resume)
        try:
            run = _Run(spec, problem, plan, store, part, stop, json_, quiet)
            run.solve(tuple(given), keep is Keep.full, chained, scheduler, processes)
        finally:
            store.close()
        raise typer.Exit(stop.exit_code if stop() else run.code)


@dataclass
class _Run:
    """A sweep whose folder is open."""

    spec: Spec
    problem: Problem
    plan: Plan
    store: Store
    part: tuple[int, int] | None
    stop: Stop
    as_json: bool
    quiet: bool
    code: int = 0

    def solve(self, given: tuple[str, ...], full: bool, chain: bool, scheduler: str | None, processes: int) -> None:
        """Solve what is missing, write the table and the arrays, and tell. They are written whatever happens."""
        from ...results.sweep.run import Job, run, todo

        told = shlex.join(["trajopt", *sys.argv[1:]])
        job = Job(self.spec.text, self.spec.file, given, told, full, chain)
        own, missing = todo(self.plan, self.store, full, self.part)
        tally = Tally(len(own), len(own) - len(missing))
        try:
            if missing:
                engine = self._engine(scheduler, min(processes, len(missing)))
                with watched(self.spec.name, tally, self.quiet) as show:
                    report = partial(self._report, tally, show)
                    run(self.plan, self.store, engine, job, missing, stop=self.stop, report=report)
        finally:
            self._write(told)
        self._tell(own, tally)

    def _engine(self, scheduler: str | None, processes: int) -> Engine:
        from ...results.sweep.engines import ClusterEngine, LocalEngine

        return (
            ClusterEngine(scheduler) if scheduler else LocalEngine(processes, prepare_workers, self.spec.solver.library)
        )

    def _report(self, tally: Tally, show: Callable[[], None], record: Mapping[str, Any] | None) -> None:
        if record is not None:
            tally.count(record)
            if self.as_json:
                print_json(record)
        show()

    def _write(self, told: str) -> None:
        """index.csv and sweep.h5, with what other shards have finished as well."""
        from ...results.sweep.dataset import write_arrays
        from ...results.sweep.store import ARRAYS, TABLE
        from ...results.sweep.tables import write_table

        phase = self.problem.phases[0]
        variables = (*phase.states, *self.problem.parameters)
        units = {name: parameter.unit for name, parameter in self.spec.parameters.items()}
        units |= {variable.name: variable.unit for variable in variables}
        about: dict[str, Any] = {"problem": self.spec.name, "sense": self.sense, "command": told}
        about |= {"design": self.plan.design, "units": {**units, "time": phase.time_unit}}
        with self.store.alone():
            records = self.store.refreshed()
            write_table(self.store.folder / TABLE, self.plan.paths, records)
            write_arrays(self.store.folder / ARRAYS, self.plan, records, about)

    @property
    def sense(self) -> str:
        return self.spec.objective.sense

    def _tell(self, own: list[int], tally: Tally) -> None:
        """The table at the end, mistakes of cases, and the exit code."""
        from ...results.sweep.case import MISTAKE
        from ...results.sweep.tables import summary_of

        summary = summary_of(self.store.records, own, self.sense)
        if not self.as_json and not self.quiet:
            passed = time.monotonic() - tally.began
            print_sweep(self.spec.name, summary, self.store.folder, passed, tally.solved + tally.failed)
        mine = set(own)
        wrong = [r for n, r in self.store.records.items() if n in mine and r["status"] == MISTAKE]
        for message in list(dict.fromkeys(record["message"] for record in wrong))[:MAX_TOLD]:
            print(f"error: {one_line(message)}", file=sys.stderr)
        self.code = USER_MISTAKE if wrong else 0 if summary["solved"] == summary["cases"] else NOT_SOLVED


def _checked(plan: Plan, spec: Spec, given: list[str]) -> Problem:
    """The problem of the file. Raises SpecError with what is wrong in a case, before anything is solved."""
    from ...results.sweep.check import check_cases

    def load(case: list[str]) -> None:
        build_checked([load_yaml(spec.text, [*given, *case], spec.file)])

    ((problem, *_),) = build_checked([spec])
    check_cases(plan, load)
    return problem
