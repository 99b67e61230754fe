"""What the library's rows were when they were last looked at, kept in the repository, and what is worse than that."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from importlib.resources import files

from ...problems.catalog import shipped
from .rows import SHORT, Row, row_from
from .table import MADE_BY

FILE = "baseline.json"

DIGIT = 0.95
"""A loss of that many digits counts as one: digits are told to a tenth."""

MORE, AT_LEAST = 1.2, 5
"""How many times the iterations, and how many more of them, count as a loss."""

WIDER = 10.0
"""How many times as wide an error bar is that has lost a digit."""

ROUNDING = 1e-7
"""Of 1 + |J|: what solves to a tolerance of 1e-8 differ by from machine to machine, where no error bar is wider."""


def baseline() -> dict[str, Row]:
    """Name of a problem -> its row of the repository."""
    text = files(__package__).joinpath(FILE).read_text(encoding="utf-8")
    return {told["name"]: row_from(told) for told in json.loads(text)["problems"]}


def renewed(rows: Sequence[Row], old: Mapping[str, Row]) -> list[Row]:
    """The rows of all shipped problems: those given, and of an earlier baseline where none is given."""
    known = {**old, **{row.name: row for row in rows}}
    return [known[name] for name in shipped() if name in known]


def baseline_text(rows: Sequence[Row]) -> str:
    """The file of a baseline: one problem a line, so that a difference of two shows which have changed."""
    lines = ",\n".join(json.dumps(row.kept, allow_nan=False) for row in rows)
    return f'{{"made_by": "{MADE_BY}", "problems": [\n{lines}\n]}}\n'


def regressions(old: Mapping[str, Row], rows: Sequence[Row], *, finer: bool = True) -> list[str]:
    """What is worse than it was, one sentence each, with the name and both values.

    old: name of a problem -> its earlier row; a problem without one has nothing to be worse than.
    rows: of now. Checks of `verify` count where both rows have some.
    finer: whether solves for more digits were made for these, so that a digit that they lost counts.
    """
    looks = (_worse, _digits_lost) if finer else (_worse,)
    known = [(old[row.name], row) for row in rows if row.name in old]
    return [f"{row.name}: {what}" for before, row in known for look in looks for what in look(before, row)]


def _worse(old: Row, new: Row) -> Iterator[str]:
    if old.solved and not new.solved:
        yield f"was solved, now: {new.message}"
        return
    if not new.solved or old.objective is None or new.objective is None:
        return
    apart = abs(new.objective - old.objective)
    if apart > _width(old) + _width(new) + ROUNDING * (1 + abs(old.objective)):
        bars = f"error bars {_width(old):.1e} and {_width(new):.1e}"
        yield f"another optimum, objective {old.objective:.10g} before, {new.objective:.10g} now, {bars}"
    if old.digits is not None and (new.digits is None or old.digits - new.digits >= DIGIT):
        yield f"{old.digits:.1f} digits agreed with the reference before, {new.digits or 0:.1f} now"
    if old.bar is not None and (new.bar is None or new.bar > max(WIDER * old.bar, ROUNDING * (1 + abs(old.objective)))):
        yield f"error bar {old.bar:.1e} before, {'none' if new.bar is None else f'{new.bar:.1e}'} now"
    if old.holds and new.holds is False:
        yield f"the error bar held before, now it is {new.bar:.1e} and the reference {new.difference:.1e} away"
    if new.iterations > MORE * old.iterations and new.iterations >= old.iterations + AT_LEAST:
        yield f"{old.iterations} iterations before, {new.iterations} now"
    if old.checks and (failed := [name for name in new.failed if name not in old.failed]):
        yield f"{len(old.failed)} checks of verify failed before, {len(new.failed)} now: {'; '.join(failed)}"


def _digits_lost(old: Row, new: Row) -> Iterator[str]:
    if new.solved and new.standing == SHORT and old.standing not in ("", SHORT):
        before = f" ({old.finer.told})" if old.finer else ""
        now = f"the finer solve: {new.finer.told}" if new.finer else "no finer solve is better"
        yield f"all published digits were told before{before}, not now ({now})"


def _width(row: Row) -> float:
    """By how much the objective may be off: its error bar, and the tolerance of the reference where there is none."""
    return next((width for width in (row.bar, row.tolerance) if width is not None), 0.0)
