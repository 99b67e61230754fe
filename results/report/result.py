"""The page of one result."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from ...problems.errors import FileError, SpecError
from ...problems.problem import Problem
from ...problems.schema.spec import Spec
from ..audit.check import Check
from ..file.bounds import bounds_of
from ..file.read import PhaseCurves, Result, read
from ..file.summary import summarize, telling
from . import charts, film, mathematics
from .page import PLOTS, rendered

HEADINGS = {
    "state": "States",
    "control": "Controls",
    "algebraic": "Algebraic variables",
    "output": "Named expressions",
    "path": "Path constraints",
    "costate": "Costates",
}
_TABLES = {"states": "state", "controls": "control", "algebraic": "algebraic variable", "outputs": "expression",
           "path": "path constraint"}  # fmt: skip
_PREFIX = "seconds_"
MESH_LINES = 2000
"""Segment edges of one mesh that are drawn: more of them are a bar."""


def result_page(path: Path, facts: Sequence[tuple[str, str]], checks: Sequence[Check] | None) -> str:
    """The page of a result file.

    path: of the result.
    facts: what is told at the top, name and text.
    checks: what `verify` found; None where it was not asked.

    Raises FileError if it is no result.
    """
    result, summary = read(path), summarize(path)
    stated, why_not = _stated(result)
    bounds = bounds_of(stated[1]) if stated else {}
    moving = film.film(result) if stated else None
    drawn = charts.curves(result, bounds)
    kinds = [(HEADINGS[kind], _named(kind, own)) for kind, own in drawn.items()]
    errors, steps = _named("error", charts.errors(result)), _named("solver", charts.convergence(result))
    every = {name: chart for _, own in [*kinds, ("", errors), ("", steps)] for name, chart in own.items()}
    return rendered(
        "result.html",
        title=result.problem,
        scripts=(*PLOTS, *(("film.js",) if moving else ())),
        result=result,
        summary=summary,
        facts=facts,
        checks=checks,
        equations=mathematics.shown_equations(*stated) if stated else [],
        parameters=mathematics.parameters(stated[0]) if stated else [],
        why_not=why_not,
        variables=_variables(summary),
        telling=telling(summary),
        kinds=kinds,
        left_out=sum(len(result.names(kind)) for kind in HEADINGS) - sum(len(own) for _, own in kinds),
        errors=errors,
        largest=_largest(result),
        meshes=_meshes(result),
        steps=steps,
        options=_options(result),
        film=moving,
        data={"charts": every, "film": moving},
    )


def _stated(result: Result) -> tuple[tuple[Spec, Problem] | None, str]:
    """The problem of the result; None and why, if this version cannot read it."""
    try:
        return result.stated(), ""
    except (FileError, SpecError) as error:
        return None, str(error.mistakes[0].what)


def _named(prefix: str, own: Sequence[charts.Chart]) -> dict[str, charts.Chart]:
    """A name for each chart, by which the page finds its data."""
    return {f"{prefix}-{number}": chart for number, chart in enumerate(own)}


def _variables(summary: Mapping[str, Any]) -> list[dict[str, Any]]:
    """A row for each curve and each static parameter, of each phase."""
    rows = []
    for phase, own in summary["phases"].items():
        for group, kind in _TABLES.items():
            rows += [{"phase": phase, "kind": kind, "name": name, **told} for name, told in own[group].items()]
        for name, told in own["parameters"].items():
            value = told["value"]
            ends = {"initial": value, "final": value, "min": value, "max": value}
            rows.append({"phase": phase, "kind": "found parameter", "name": name, "unit": told["unit"], **ends})
    return rows


def _largest(result: Result) -> list[dict[str, Any]]:
    """The segments that add most to the error bar, the largest first."""
    shares = [(float(share), phase, i) for phase in result.phases for i, share in enumerate(phase.shares)]
    whole = sum(share for share, _, _ in shares)
    largest = sorted(shares, key=lambda own: -own[0])[:5]
    return [_segment(phase, i, share, share / whole) for share, phase, i in largest if whole > 0]


def _segment(phase: PhaseCurves, i: int, share: float, part: float) -> dict[str, Any]:
    eta = max(phase.eta, key=lambda state: phase.eta[state][i])
    times = f"{phase.knots[i]:.4g} to {phase.knots[i + 1]:.4g} {phase.time_unit}"
    return {"phase": phase.name, "number": i + 1, "times": times, "share": share, "part": part, "state": eta}


def _meshes(result: Result) -> list[dict[str, Any]]:
    """The edges of each mesh as the path of a drawing 1000 wide: strokes where segments meet."""
    start, end = result.phases[0].knots[0], result.phases[-1].knots[-1]
    scale = 1000 / (end - start) if end > start else 0.0
    drawn = []
    for mesh in result.meshes:
        strokes = []
        for phase, edges in zip(result.phases, mesh.edges, strict=True):
            times = phase.knots[0] + (phase.knots[-1] - phase.knots[0]) * edges
            step = max(len(times) // MESH_LINES, 1)
            strokes += [f"M{(t - start) * scale:.1f} 0V16" for t in times[::step]]
        drawn.append({"method": mesh.method, "segments": mesh.segments, "path": "".join(strokes)})
    return drawn


def _options(result: Result) -> dict[str, Any]:
    """What the solver was told; its seconds stand elsewhere."""
    return {name: value for name, value in result.options.items() if not name.startswith(_PREFIX)}
