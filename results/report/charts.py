"""Curves of a result as plain data that `assets/charts.js` draws.

A chart is {title, unit, note, x: {label, values, sync}, series: [{label, kind, colour, values}], log, bounds, marks,
phases}. Values of all series stand at the same x; None where a series has none. kind is line, points, marked (a line
with points) or steps. Charts of one `sync` are zoomed together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...problems.quantities import Range
from ..file.bounds import bounds_beside
from ..file.read import CURVE_KINDS, Curve, MeasuredPoints, PhaseCurves, Result, beside_each_other
from .over_time import Times, plain_series, rounded_numbers

Chart = dict[str, Any]
Bounds = Mapping[str, Mapping[str, Range]]

MOST_CHARTS = 150
SAMPLES = 1500  # of one curve of one phase
POINTS = 500  # of all phases, beyond which they would only hide the curve
NEAR_TIMES = 1e-9  # of the duration: times that are one


def curves(result: Result, bounds: Bounds) -> dict[str, list[Chart]]:
    """Kind -> a chart for each of its quantities, at most MOST_CHARTS in all.

    bounds: phase -> name -> range, as `bounds_of` gives them; empty for none.
    """
    left = MOST_CHARTS
    found: dict[str, list[Chart]] = {}
    for kind in CURVE_KINDS:
        names = result.names(kind)[:left]
        left -= len(names)
        if names:
            found[kind] = [curve(result, kind, name, {} if kind == "costate" else bounds) for name in names]
    return found


def curve(result: Result, kind: str, name: str, bounds: Bounds) -> Chart:
    """One quantity of all phases over time: the method's own interpolant, and the points of the mesh.

    result: at least one of its phases has the quantity.
    kind: one of CURVE_KINDS.
    name: of the quantity; of a costate, that of its state.
    bounds: as of `curves`.
    """
    phases = [phase for phase in result.phases if name in phase.curves.get(kind, {})]
    samples = [_samples(phase, phase.curves[kind][name], _measured(phase, kind, name)) for phase in phases]
    times = _times(phases, [own for own, _ in samples])
    series = times.curves(kind, "line", kind, [values for _, values in samples])
    if sum(len(phase.time) for phase in phases) <= POINTS:
        for label, at_knot in (("knot", True), ("point inside a segment", False)):
            marks = [
                _at_points(own, phase, phase.curves[kind][name], at_knot)
                for own, phase in zip(times.parts, phases, strict=True)
            ]
            if any(np.isfinite(values).any() for values in marks):
                series.append(times.marks(label, "ink" if at_knot else kind, marks))
    if any(_measured(phase, kind, name) for phase in phases):
        told = [_of_measured(own, _measured(p, kind, name)) for own, p in zip(times.parts, phases, strict=True)]
        series.append(times.marks("measured", "bad", told))
    near, far = _bounds(phases, kind, name, bounds)
    unit = phases[0].curves[kind][name].unit
    title = f"costate of {name}" if kind == "costate" else name
    chart = _chart(title, unit, _time(phases[0]), times.axis(), series)
    return {**chart, "bounds": near, "note": far, "marks": _marks(phases), "phases": _edges(result.phases)}


def errors(result: Result) -> list[Chart]:
    """eta of every state by segment, and what each segment adds to the error bar of the objective."""
    phases = result.phases
    times = _times(phases, [phase.knots for phase in phases])
    label = _time(phases[0])
    by_state = [
        own
        for i, state in enumerate(result.states)
        for own in times.curves(state, "steps", f"line{i}", [_on_knots(p, p.eta.get(state)) for p in phases])
    ]
    charts = [{**_chart("η of each state", "the state's unit", label, times.axis(), by_state), "log": True}]
    relative = [_on_knots(phase, phase.relative) for phase in phases]
    charts.append(_by_segment("largest relative η", label, times, relative, "state"))
    if any(len(phase.shares) for phase in phases):
        shares = [_on_knots(phase, phase.shares) for phase in phases]
        charts.append(_by_segment("part of the error bar of the objective", label, times, shares, "control"))
    return [{**chart, "phases": _edges(phases)} for chart in charts]


def _by_segment(title: str, label: str, times: Times, parts: list[np.ndarray], colour: str) -> Chart:
    return {**_chart(title, "", label, times.axis(), times.curves(title, "steps", colour, parts)), "log": True}


def convergence(result: Result) -> list[Chart]:
    """What the solver reported at each iteration."""
    told = result.iterations
    if not len(told.get("iteration", ())):
        return []
    number = rounded_numbers(np.arange(len(told["iteration"])))
    shown = {
        "infeasibility and barrier": ("primal_infeasibility", "dual_infeasibility", "mu"),
        "objective": ("objective",),
        "step": ("step_norm",),
        "step length": ("primal_step", "dual_step"),
    }
    charts = []
    for title, names in shown.items():
        series = [
            plain_series(name.replace("_", " "), "line", f"line{i}", rounded_numbers(told[name]))
            for i, name in enumerate(names)
            if name in told
        ]
        if series:
            log = title not in ("objective", "step length")
            charts.append({**_chart(title, "", "record", number, series, sync=""), "log": log})
    return charts


def _chart(
    title: str, unit: str, label: str, x: Sequence[float | None], series: list[dict[str, Any]], sync: str = "time"
) -> Chart:
    unit = "" if unit == "1" else unit
    over = {"label": label, "values": x, "sync": sync}
    empty = {"log": False, "note": "", "bounds": [], "marks": [], "phases": []}
    return {"title": title, "unit": unit, "x": over, "series": series, **empty}


def _time(phase: PhaseCurves) -> str:
    return f"time [{phase.time_unit}]" if phase.time_unit not in ("", "1") else "time"


def _times(phases: Sequence[PhaseCurves], parts: Sequence[np.ndarray]) -> Times:
    return Times([phase.name for phase in phases], parts, beside_each_other(phases))


def _samples(phase: PhaseCurves, own: Curve, measured: Sequence[MeasuredPoints]) -> tuple[np.ndarray, np.ndarray]:
    """Times and values of the dense curve, thinned to what a screen can show; points of the mesh and measurements too.

    A time that was measured n times stands n times.
    """
    kept = _thinned(own.dense)
    points = phase.time if len(phase.time) <= POINTS else phase.time[:0]
    seen, count = np.unique(_measured_times(measured), return_counts=True)
    times = np.unique(np.concatenate([phase.dense_time[kept], points, seen]))
    apart = np.diff(times, prepend=-np.inf) > NEAR_TIMES * abs(
        phase.knots[-1] - phase.knots[0]
    )  # the same but for rounding
    times = np.sort(np.append(times[apart], np.repeat(seen, count - 1)))
    return times, np.interp(times, phase.dense_time, own.dense)


def _measured(phase: PhaseCurves, kind: str, name: str) -> list[MeasuredPoints]:
    return [] if kind == "costate" else [own for own in phase.measured if own.expression == name]


def _measured_times(measured: Sequence[MeasuredPoints]) -> np.ndarray:
    return np.concatenate([np.empty(0), *(own.time for own in measured)])


def _of_measured(times: np.ndarray, measured: Sequence[MeasuredPoints]) -> np.ndarray:
    """What was measured, at the nearest of the times, NaN at all others; what has the same time at the next ones."""
    values = np.full(len(times), np.nan)
    at, value = _measured_times(measured), np.concatenate([np.empty(0), *(own.value for own in measured)])
    order = np.argsort(at, kind="stable")
    first = np.searchsorted((times[1:] + times[:-1]) / 2, at[order])
    repeated = np.arange(len(at)) - np.searchsorted(at[order], at[order])
    values[np.minimum(first + repeated, len(times) - 1)] = value[order]
    return values


def _thinned(values: np.ndarray) -> np.ndarray:
    """Indices of the least and the largest of every few values, so that no spike is lost; all of a short curve."""
    if len(values) <= SAMPLES:
        return np.arange(len(values))
    parts = np.array_split(np.arange(len(values)), SAMPLES // 2)
    finite = np.nan_to_num(values, nan=0.0)
    ends = [0, len(values) - 1]
    return np.unique([*ends, *(part[i] for part in parts for i in (finite[part].argmin(), finite[part].argmax()))])


def _at_points(times: np.ndarray, phase: PhaseCurves, own: Curve, at_knot: bool) -> np.ndarray:
    """The values at the points that are knots, or that are none, NaN at all other times."""
    values = np.full(len(times), np.nan)
    wanted = phase.at_knot == at_knot
    middles = (times[1:] + times[:-1]) / 2
    values[np.searchsorted(middles, phase.time[wanted])] = own.points[wanted]
    return values


def _on_knots(phase: PhaseCurves, values: np.ndarray | None) -> np.ndarray:
    """Values of segments at the segments' left ends, the last one again at the right end; shape (N + 1,)."""
    if values is None or not len(values):
        return np.full(len(phase.knots), np.nan)
    return np.append(values, values[-1])


def _bounds(phases: Sequence[PhaseCurves], kind: str, name: str, bounds: Bounds) -> tuple[list[dict[str, float]], str]:
    """The bounds that are drawn, each over its phase, and those that are far off, in words."""
    near, far = [], []
    for phase, value, upper, is_near in bounds_beside(phases, kind, name, bounds):
        if is_near:
            near.append({"value": value, "from": float(phase.knots[0]), "to": float(phase.knots[-1])})
        else:
            far.append(f"{'≤' if upper else '≥'} {value:.4g}".replace("-", "\N{MINUS SIGN}"))
    return near, "bounds " + " and ".join(dict.fromkeys(far)) if far else ""


def _marks(phases: Sequence[PhaseCurves]) -> list[float | None]:
    """The segments' edges, if they can be told apart."""
    knots = np.concatenate([phase.knots for phase in phases])
    return rounded_numbers(knots) if len(knots) <= POINTS else []


def _edges(phases: Sequence[PhaseCurves]) -> list[dict[str, Any]]:
    """Names and times of phases that follow each other; the legend names others."""
    if len(phases) < 2 or beside_each_other(phases):
        return []
    return [{"name": p.name, "from": float(p.knots[0]), "to": float(p.knots[-1])} for p in phases]
