"""The records of a sweep as a table, and what is told of them at the end."""

from __future__ import annotations

import csv
import io
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from ...problems.files import write_whole

Record = Mapping[str, Any]

SCALARS = {
    "objective": "objective",
    "objective_error": "the optimum is at most this far from the objective",
    "iterations": "iterations, on all meshes",
    "seconds": "seconds that the case took",
    "final_time": "final time",
}
"""Numbers that each record has, in words."""

TEXTS = {
    "status": "how the solve ended",
    "message": "the same in words",
    "inaccurate": "why a solved case is not as accurate as was asked",
    "start": "what the case was started from",
    "key": "name of the files of the case",
}


def groups(records: Iterable[Record]) -> dict[str, list[str]]:
    """Of "initial" and "final" the states, and of "parameters" the names, that any record has, in their order."""
    found: dict[str, dict[str, None]] = {"initial": {}, "final": {}, "parameters": {}}
    for record in records:
        for group in found:
            found[group] |= dict.fromkeys(record[group])
    return {group: list(names) for group, names in found.items()}


def column(group: str, name: str) -> str:
    """The name of a column or an array: initial_x, final_x, or that of a parameter that was found."""
    return f"found_{name}" if group == "parameters" else f"{group}_{name}"


def write_table(path: Path, paths: Sequence[str], records: Mapping[int, Record]) -> None:
    """One line for each case that has ended, in the order of cases. Raises FileError.

    path: of the CSV file.
    paths: of what is swept.
    records: by the number of the case, from 0.
    """
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    named = groups(records.values())
    pairs = [(group, name) for group, names in named.items() for name in names]
    head = ["case", *paths, "status", "solved", *SCALARS, *(column(*pair) for pair in pairs)]
    writer.writerow([*head, "start", "inaccurate", "message", "key"])
    for number in sorted(records):
        r = records[number]
        told = [number, *(r["values"][path] for path in paths), r["status"], str(r["solved"]).lower()]
        numbers = [*(r[name] for name in SCALARS), *(r[group].get(name) for group, name in pairs)]
        shown = ["" if x is None else repr(x) for x in numbers]
        writer.writerow([*told, *shown, r["start"], r["inaccurate"], r["message"], r["key"]])
    write_whole(path, stream.getvalue())


def summary_of(records: Mapping[int, Record], wanted: Sequence[int], sense: str) -> dict[str, Any]:
    """What is told at the end.

    records: by the number of the case.
    wanted: the cases that this process was to solve.
    sense: "minimize" or "maximize", which says what is best.
    """
    ended = [records[number] for number in wanted if number in records]
    solved = sorted((r for r in ended if r["solved"]), key=lambda r: r["objective"], reverse=sense == "maximize")
    reasons = Counter((r["status"], r["message"]) for r in ended if not r["solved"])
    by_status: dict[str, dict[str, Any]] = {}
    for (status, message), count in reasons.most_common():
        entry = by_status.setdefault(status, {"cases": 0, "message": message})
        entry["cases"] += count
    return {
        "cases": len(wanted),
        "solved": len(solved),
        "failed": len(ended) - len(solved),
        "missing": len(wanted) - len(ended),
        "inaccurate": sum(bool(r["inaccurate"]) for r in solved),
        "reasons": by_status,
        "best": solved[0] if solved else None,
        "worst": solved[-1] if solved else None,
    }
