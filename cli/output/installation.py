"""What `trajopt doctor` found, for people."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from .printing import print_field, print_title

DERIVATIVES = {"llvm": "compiled by LLVM", "lambda": "interpreted, as this SymEngine has no LLVM: slower, as exact"}


def print_installation(found: dict[str, Any]) -> None:
    """A title that says whether it solves, and a line for each thing that was looked at."""
    print_title(f"trajopt {found['trajopt']}: {'it solves' if found['solves'] else 'IT CANNOT SOLVE'}", found["solves"])
    for name, text in _rows(found):
        print_field(name, text)


def _rows(found: dict[str, Any]) -> Iterator[tuple[str, str]]:
    trial, broken = found["trial"], found["unusable"]
    if found["solves"]:
        yield "trial", f"{trial['problem']}: objective {trial['objective']:.10g} is right; {trial['seconds']:.2g} s"
    else:
        yield "trouble", f"{trial['problem']}: {trial['trouble']}"
        yield "remedy", trial["remedy"]
    yield from (("misfit", sentence) for sentence in found["misfits"])
    yield from (("broken", f"{name}: {why}") for name, why in broken.items())
    yield "folder", found["folder"]
    yield "python", found["python"]
    yield "system", found["system"]
    yield "packages", ", ".join(f"{name} {version or 'MISSING'}" for name, version in found["packages"].items())
    yield "ipopt", found["ipopt"] or "?"
    yield "solvers", _solvers(found["linear_solvers"] or {})
    yield "hdf5", found["hdf5"] or "?"
    yield "derivatives", DERIVATIVES.get(found["derivatives"], "?")
    yield from (("cache", f"of {name}: {folder or 'none'}") for name, folder in found["caches"].items())
    yield from ((name, _part(part)) for name, part in found["parts"].items())
    if found["environment"]:
        yield "environment", " ".join(f"{name}={value}" for name, value in found["environment"].items())


def _solvers(works: dict[str, bool]) -> str:
    """Linear solvers, those that work first."""
    lists = {there: ", ".join(name for name, own in works.items() if own is there) for there in (True, False)}
    return f"{lists[True] or 'none'}; no library for {lists[False]}" if lists[False] else lists[True] or "?"


def _part(part: dict[str, Any]) -> str:
    if not part["missing"]:
        return f"{part['gives']}: yes"
    return f"{part['gives']}: no {' and '.join(part['missing'])}; {part['remedy']}"
