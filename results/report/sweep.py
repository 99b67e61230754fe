"""The page of a sweep's folder."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.problem import Guess, Problem
from ...problems.schema.spec import Spec
from ...problems.text import shorten
from ...problems.yaml.document import value_of
from ...transcription.loading import build_checked, load_yaml
from ..sweep.dataset import dimensions
from ..sweep.plan import GRID, Plan, stored_plan
from ..sweep.store import ABOUT, RESULTS, curves_in, records_in, stored_about
from ..sweep.tables import SCALARS, Record, column, groups, summary_of
from . import mathematics
from .over_time import rounded_numbers
from .page import PLOTS, rendered

MOST_CASES = 20_000
"""Cases that a page holds; index.csv has all."""

NUMBERS = 400_000
"""Values of curves that a page holds, of all cases together: some 3 MB."""

FEWEST = 12
"""Samples of one curve, below which it would be none."""

DIGITS = 4, 7, 10
"""Of the values of an axis, the fewest that tell all of them apart."""

REASONS = 50
LONGEST = 400  # letters of a message


def sweep_page(folder: Path) -> str:
    """The page of the folder of a sweep, which may still be at work.

    folder: of `trajopt sweep`.

    Raises FileError if the folder holds no sweep of this version.
    """
    about, plan = _opened(folder)
    records = records_in(folder, plan)
    shown = dict(list(records.items())[:MOST_CASES])
    stated, why_not = _stated(about)
    sense = stated[0].objective.sense if stated else "minimize"
    axes = _axes(plan, shown)
    failed = Counter((r["status"], r["message"]) for r in records.values() if not r["solved"])
    data = {
        "axes": axes,
        "grid": plan.design == GRID,
        "columns": _columns(axes, shown, _units(stated)),
        "curves": _curves_of_cases(folder, shown),
        "results": sorted(n for n, r in shown.items() if r["key"] and (folder / RESULTS / f"{r['key']}.h5").exists()),
        "folder": folder.name,
    }
    return rendered(
        "sweep.html",
        title=stated[0].name if stated else Path(str(about.get("file", ""))).stem or folder.name,
        scripts=(*PLOTS, "sweep.js"),
        folder=folder.name,
        plan=plan,
        about=about,
        ended=len(records),
        summary=summary_of(records, range(len(plan)), sense),
        reasons=[(status, message, count) for (status, message), count in failed.most_common(REASONS)],
        left_out=len(records) - len(shown),
        equations=mathematics.shown_equations(*stated) if stated else [],
        parameters=mathematics.parameters(stated[0]) if stated else [],
        several=stated is not None and len(stated[1].phases) > 1,
        why_not=why_not,
        sense=sense,
        data={"charts": {}, "sweep": data},
    )


def _opened(folder: Path) -> tuple[dict[str, Any], Plan]:
    remedy = "give a result, or the folder that 'trajopt sweep' has made"
    if not (folder / ABOUT).is_file():
        raise FileError(Mistake(str(folder), "the folder holds no sweep", _near(folder) or remedy))
    try:
        about = stored_about(folder, remedy)
        return about, stored_plan(about, str(folder / ABOUT))
    except SpecError as error:  # of a folder that was given to be read
        raise FileError(error.mistakes) from error


def _near(folder: Path) -> str:
    """The sweep that may have been meant: one that stands in the folder."""
    inside = sorted(path.parent for path in folder.glob(f"*/{ABOUT}"))
    return f"did you mean {inside[0]}?" if inside else ""


def _stated(about: Mapping[str, Any]) -> tuple[tuple[Spec, Problem] | None, str]:
    """The problem without what is swept; None and why, if it cannot be read."""
    text, overrides, file = about.get("text"), about.get("overrides"), about.get("file")
    if not (isinstance(text, str) and isinstance(file, str) and isinstance(overrides, list)):
        return None, "the folder does not tell it"
    try:
        spec = load_yaml(text, [str(own) for own in overrides], file)
        ((problem, *_),) = build_checked([spec])
        return (spec, problem), ""
    except (SpecError, FileError) as error:
        return None, str(error.mistakes[0].what)


def _units(stated: tuple[Spec, Problem] | None) -> dict[str, str]:
    if stated is None:
        return {}
    spec, problem = stated
    named = {name: parameter.unit for name, parameter in spec.parameters.items()}
    variables = (*problem.phases[0].states, *problem.parameters)
    return {**named, **{v.name: v.unit for v in variables}, "": problem.phases[0].time_unit}


def _axes(plan: Plan, records: Mapping[int, Record]) -> list[dict[str, Any]]:
    """What was swept: its values, as numbers if all of them are, and which of them each case has."""
    names = dimensions(plan.paths, ())
    axes = []
    for number, (axis, name) in enumerate(zip(plan.axes, names, strict=True)):
        distinct = list(dict.fromkeys(axis.values))
        place = {value: i for i, value in enumerate(distinct)}
        own = [place[axis.values[plan.place(case)[number]]] for case in records]
        plain = [value_of(value, "") for value in distinct]
        numeric = all(isinstance(v, int | float) and not isinstance(v, bool) for v in plain)
        numbers = rounded_numbers(plain) if numeric else None
        texts = _told(plain, distinct) if numeric else distinct
        axes.append({"path": axis.path, "name": name, "texts": texts, "numbers": numbers, "of": own})
    return axes


def _told(numbers: Sequence[float], exact: list[str]) -> list[str]:
    """Numbers for a reader, in as few digits as tell them apart; exact: as they were given."""
    for digits in DIGITS:
        texts = [f"{number:.{digits}g}" for number in numbers]
        if len(set(texts)) == len(texts):
            return texts
    return exact


def _columns(
    axes: Sequence[Mapping[str, Any]], records: Mapping[int, Record], units: Mapping[str, str]
) -> list[dict[str, Any]]:
    """The columns of the table, of index.csv: what it is called, and a value for each case. main: shown at first."""
    rows = list(records.values())
    columns = [_number("case", list(records), main=True)]
    for axis in axes:
        path, own = axis["path"], axis["of"]
        if axis["numbers"] is None:
            columns.append(_text(path, [axis["texts"][i] for i in own], main=True))
        else:
            section, _, name = path.partition(".")
            unit = units.get(name, "") if section == "parameters" else ""
            columns.append(_number(path, [axis["numbers"][i] for i in own], unit, main=True))
    columns.append(_text("status", [r["status"] for r in rows], main=True))
    for name in SCALARS:
        unit = {"final_time": units.get("", ""), "seconds": "s"}.get(name, "")
        columns.append(_number(name, [r[name] for r in rows], unit, main=name != "final_time"))
    for group, names in groups(rows).items():
        for name in names:
            values = [r[group].get(name) for r in rows]
            columns.append(_number(column(group, name), values, units.get(name, ""), main=group == "parameters"))
    for name in ("start", "inaccurate", "message", "key"):
        columns.append(_text(name, [shorten(r[name], LONGEST) for r in rows], main=name == "message"))
    columns.append(_number("solved", [int(r["solved"]) for r in rows], main=False))
    return columns


def _number(name: str, values: Iterable[float | None], unit: str = "", *, main: bool) -> dict[str, Any]:
    return {"name": name, "unit": unit, "main": main, "numbers": rounded_numbers(values)}


def _text(name: str, values: Sequence[str], *, main: bool) -> dict[str, Any]:
    """Texts that come up often stand once."""
    distinct = list(dict.fromkeys(values))
    place = {text: i for i, text in enumerate(distinct)}
    return {"name": name, "unit": "", "main": main, "texts": distinct, "of": [place[value] for value in values]}


def _curves_of_cases(folder: Path, records: Mapping[int, Record]) -> dict[str, Any] | None:
    """The curves of each case as `small` has kept them, thinned so that the page stays small; None for too many."""
    grids: list[list[float | None]] = []
    known: dict[bytes, int] = {}
    solved = [record for record in records.values() if record["solved"]]
    samples = FEWEST
    for record in solved[:1]:
        size = sum(len(guess.values) for guess in (curves_in(folder, record) or {}).values())
        samples = NUMBERS // max(size * len(solved), 1)
    if samples < FEWEST or not solved:
        return None

    def one(name: str, guess: Guess) -> dict[str, Any]:
        step = max(-(-len(guess.s) // samples), 1)
        kept = np.unique([*range(0, len(guess.s), step), len(guess.s) - 1])
        grid = guess.s[kept]
        number = known.setdefault(grid.tobytes(), len(grids))
        if number == len(grids):
            grids.append(rounded_numbers(grid))
        values = {curve: rounded_numbers(own[kept]) for curve, own in guess.values.items()}
        return {"phase": name, "from": guess.initial_time, "to": guess.final_time, "grid": number, "values": values}

    cases = [[one(*own) for own in (curves_in(folder, r) or {}).items()] for r in records.values()]
    return {"grids": grids, "cases": cases}
