"""Options of `trajopt sweep`, or the section `sweep:` of the file -> the cases that are meant."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from ...problems.errors import Mistake, SpecError
from ...problems.lean.records import dataclass
from ...problems.text import brief

if TYPE_CHECKING:
    from ...problems.schema.spec import Spec
    from ...results.sweep.axes import Axis
    from ...results.sweep.plan import Plan

MOST_JOBS = 10_000


@dataclass(frozen=True)
class Asked:
    """What the command line says of the cases; None and False for what it leaves open."""

    over: Sequence[str] | None
    zip: bool
    list: Path | None
    sample: str | None
    seed: str | None
    chain: bool | None


def planned_cases(asked: Asked, spec: Spec, given: Sequence[str]) -> tuple[Plan, bool]:
    """The cases, and whether each starts from the one before it.

    asked: on the command line; --over or --list takes the place of the whole section of the file.
    spec: the file.
    given: overrides of every case, which no axis may vary.

    Raises SpecError for what contradicts itself or cannot be meant, FileError if a table cannot be read.
    """
    from ...problems.schema.solving import MAX_CASES, MAX_SEED  # not before: `trajopt --help` needs no pydantic
    from ...results.sweep import plan as plans

    section = None if asked.over or asked.list else spec.sweep
    chain = asked.chain if asked.chain is not None else bool(section and section.chain)
    sample = section.sample if section and not asked.sample else None
    if asked.sample:
        sample = whole_option("--sample", asked.sample, 1, MAX_CASES)
    _refuse(asked, sample is not None, bool(section and section.zip))
    if asked.list:
        plan = plans.listed_in_file(asked.list)
    else:
        axes = _axes(asked, spec, sample is not None)
        if sample is not None:
            seed = whole_option("--seed", asked.seed, 0, MAX_SEED) if asked.seed else section.seed if section else 0
            plan = plans.sampled(axes, sample, seed)
        elif asked.zip or (section and section.zip):
            plan = plans.zipped(axes)
        else:
            plan = plans.grid(axes)
    if chain and not plan.ordered:
        what = f"the cases of a {plan.design} have no neighbours to start from"
        raise SpecError(Mistake("--chain", what, "leave it out, or sweep a grid"))
    for path in plan.paths:
        if any(override.partition("=")[0].strip() == path for override in given):
            raise SpecError(Mistake(f"--over {path}", "the field is also set for all cases", "do one of the two"))
    return plan, chain


def shard(text: str | None, chain: bool, force: bool) -> tuple[int, int] | None:
    """(i, n) of "i/n"; None if there is none. Raises SpecError, also for what shards cannot do."""
    if text is None:
        return None
    part, slash, parts = text.partition("/")
    if not slash or not part.isdecimal() or not parts.isdecimal() or not 1 <= int(part) <= int(parts):
        raise SpecError(Mistake(f"--shard {brief(text)}", "this is no part of a sweep", "write 1/8, 2/8, ... 8/8"))
    if chain:
        what = "a case would wait for its neighbour, which another shard solves"
        raise SpecError(Mistake("--shard", what, "leave out --chain"))
    if force:
        what = "each shard would throw away what the others have solved"
        raise SpecError(Mistake("--force", what, "remove the folder before the first shard starts"))
    return int(part), int(parts)


def whole_option(option: str, text: str, smallest: int, largest: int) -> int:
    """A whole number of the command line. Raises SpecError."""
    if not text.isdecimal() or not smallest <= int(text) <= largest:
        what = f'"{brief(text)}" is no number for it'
        raise SpecError(Mistake(option, what, f"write a whole number from {smallest} to {largest}"))
    return int(text)


def processes_of(jobs: str | None) -> int:
    """The number of processes that --jobs asks for, one for each CPU without it. Raises SpecError."""
    from ...results.installation import processors

    return whole_option("--jobs", jobs, 1, MOST_JOBS) if jobs else processors()


def _refuse(asked: Asked, sample: bool, zipped: bool) -> None:
    """What contradicts itself."""
    if asked.list and (asked.over or asked.zip or asked.sample):
        raise SpecError(Mistake("--list", "the table has all cases", "leave out --over, --zip and --sample"))
    if sample and (asked.zip or zipped):
        raise SpecError(Mistake("--zip", "a sample varies all axes by itself", "leave out one of --zip and --sample"))
    if asked.seed and not sample:
        raise SpecError(Mistake("--seed", "there is no sample that it could be for", "add --sample N, or leave it out"))


def _axes(asked: Asked, spec: Spec, sampled: bool) -> list[Axis]:
    """Raises SpecError with the mistakes of all axes."""
    from ...results.sweep.axes import axis_of, parse_axis

    if not asked.over and spec.sweep is None:
        remedy = "add --over PATH=START:STOP:COUNT, --list CSV, or a section sweep: to the file"
        raise SpecError(Mistake("sweep", "nothing is varied", remedy))
    axes: list[Axis] = []
    mistakes: list[Mistake] = []
    items = [(text, None) for text in asked.over or ()] or list((spec.sweep.over if spec.sweep else {}).items())
    for path, values in items:
        try:
            where = f"{spec.file}: sweep.over.{brief(path)}"
            axes.append(parse_axis(path, sampled) if values is None else axis_of(path, values, where, sampled))
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(mistakes)
    return axes
