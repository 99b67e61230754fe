"""Summaries for people: the tables at the end of `solve` and of `show`."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from ...problems.text import with_bar
from ...results.file.summary import CONTINUOUS, DISCRETE, STATIC, causes
from .arcs import few_arcs, print_arcs
from .estimates import estimate_lines, print_correlation
from .printing import cell, one_line, plural, print_field, print_table, print_title

MAX_SHOWN = 8  # values found where there is no time
MAX_RELIEF = 4  # ways out, of a problem that contradicts itself

ROUNDING = 1e-9
"""Of the largest time: what is nearer to 0, as in a phase that has shrunk to nothing, is told as 0."""

HELD = 1e-6
"""Of the range of a curve: an excess below this is the engine's tolerance."""


def print_summary(summary: dict[str, Any]) -> None:
    """The short table: status, objective, error, iterations, seconds by part, file; and what to do if it failed."""
    solved = summary["solved"]
    verdict = "NOT SOLVED" if not solved else "solved, tolerance missed" if summary["inaccurate"] else "solved"
    print_title(f"{summary['problem']}: {verdict}", verdict == "solved")
    for name, text in table_rows(summary):
        print_field(name, text)


def table_rows(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What is told of a result, a row of the table each: what it is, and the text."""
    summary = _rounded(summary)
    if not summary["solved"]:
        yield from _failure(summary)
    if summary["optimizes"]:
        yield "objective", f"{_objective(summary)}  ({summary['sense']}){_reference(summary)}"
        yield from (("optimum", text) for text in _optimum(summary))
    yield from _found(summary)
    yield from _shortfalls(summary)
    yield "mesh" if CONTINUOUS in _kinds(summary) else "size", _size(summary)
    left = len(summary["discarded"])
    solves = len(summary["meshes"]) + left
    meshes = (f" on {solves} meshes" if solves > 1 else "") + (f", {left} of them not kept" if left else "")
    yield "iterations", f"{summary['iterations']}{meshes}"
    seconds = dict(summary["seconds"])
    total = seconds.pop("total")
    parts = ", ".join(f"{part.replace('_', ' ')} {value:.3f}" for part, value in seconds.items())
    yield "seconds", f"{total:.3f}  ({parts})"
    yield "file", summary["file"]


def _rounded(summary: dict[str, Any]) -> dict[str, Any]:
    """The same, but that times which are 0 but for rounding are 0."""
    phases = summary["phases"]
    ends = [abs(phase["time"][end] or 0.0) for phase in phases.values() for end in ("initial", "final")]
    least = ROUNDING * max(ends)

    def told(own: dict[str, Any] | None, *times: str) -> dict[str, Any] | None:
        return own and {**own, **{key: 0.0 for key in times if own.get(key) is not None and abs(own[key]) < least}}

    return {
        **summary,
        "phases": {
            name: {
                **phase,
                "time": told(phase["time"], "initial", "final"),
                "complementarity": {pair: told(own, "time") for pair, own in phase["complementarity"].items()},
            }
            for name, phase in phases.items()
        },
        "error": told(summary["error"], "start", "end"),
        "overshoot": told(summary["overshoot"], "time"),
    }


def _failure(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Why a problem is not solved, and what to do."""
    yield "status", summary["message"]
    relief = summary["relief"][:MAX_RELIEF]
    yield from zip(("relax", *["or"] * (len(relief) - 1)), relief, strict=True) if relief else ()
    yield from (("cause", cause) for cause in causes(summary["trouble"], summary["violations"], summary["involved"]))
    yield "remedy", summary["remedy"]


def _kinds(summary: dict[str, Any]) -> set[str]:
    """What time is in the phases: of STATIC, DISCRETE and CONTINUOUS."""
    return {phase["kind"] for phase in summary["phases"].values()}


def _found(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The phases, or the point where there is no time; how far dynamics and bounds are missed; what program it is."""
    several, kinds = len(summary["phases"]) > 1, _kinds(summary)
    if several:
        yield from (("phase", _phase_line(name, phase)) for name, phase in summary["phases"].items())
    yield from estimate_lines(summary["estimates"])
    if kinds == {STATIC}:
        yield from _point(next(iter(summary["phases"].values())))
    if CONTINUOUS in kinds:
        yield "error", _error(summary["error"], summary["meshes"][-1]["relative_error"], several)
        if summary["solved"]:
            yield "bounds", _bounds(summary["overshoot"], summary["phases"])
    yield from (("arcs", text) for text in few_arcs(summary["phases"]))
    yield from (("pair", text) for text in _pairs(summary["phases"], several))
    if summary["program"]:
        yield "program", summary["program"]


def _shortfalls(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What misses the tolerance, what was done beyond what was asked, and why refinement ended."""
    if summary["unmet_count"]:
        count = f"{summary['unmet_count']} of {summary['meshes'][-1]['segments']} segments"
        worst = "".join(f"; the worst: {own}" for own in summary["unmet"][:1])
        yield "refinement", f"{count} miss the tolerance{worst}"
    yield from (("note", note) for note in summary["notes"])
    yield from (("on the way", step) for step in summary["continuation"][:-1])
    if summary["stopped"]:
        yield "stopped", summary["stopped"]
    if summary["inaccurate"] and not summary["unmet_count"] and not summary["stopped"]:
        yield "accuracy", summary["inaccurate"]


def _size(summary: dict[str, Any]) -> str:
    """The last mesh; of what needs none, steps, unknowns and constraints."""
    mesh, kinds = summary["meshes"][-1], _kinds(summary)
    if CONTINUOUS in kinds:
        methods = ", ".join(dict.fromkeys(phase["method"] for phase in summary["phases"].values()))
        return f"{methods}, {mesh['segments']} segments, {mesh['unknowns']} unknowns"
    steps = f"{plural(mesh['segments'], 'step')}, " if DISCRETE in kinds else ""
    return f"{steps}{plural(mesh['unknowns'], 'unknown')}, {plural(mesh['constraints'], 'constraint')}"


def _point(phase: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """The values found where there is no time, and what the constraints are worth; the first of many."""
    found = [
        f"{name} = {_number(own['value'], 10)} {own['unit']}".rstrip() for name, own in phase["parameters"].items()
    ]
    yield "point", _some(found)
    prices = [f"{name} {_number(value)}" for name, value in phase["prices"].items() if value]
    if prices:
        yield "prices", f"{_some(prices)}  (change of the objective with the bound)"


def _some(texts: list[str]) -> str:
    more = f" and {len(texts) - MAX_SHOWN} more" if len(texts) > MAX_SHOWN else ""
    return ", ".join(texts[:MAX_SHOWN]) + more


def _objective(summary: dict[str, Any]) -> str:
    """The objective with its error bar, and as many digits as that supports; without one, ten."""
    value, bar = summary["objective"], summary["objective_error"]
    return _number(value, 10) if bar is None or value is None else " +- ".join(with_bar(value, bar))


def _optimum(summary: dict[str, Any]) -> Iterator[str]:
    """What else is known: a better value, where the digits of the bar show the difference; or why there is no bar."""
    objective, bar, better = (summary[key] for key in ("objective", "objective_error", "objective_corrected"))
    if bar is None or objective is None:
        yield f"no error bar: {summary['objective_error_missing']}"
        return
    last_digit = 10.0 ** math.floor(math.log10(float(with_bar(objective, bar)[1])))
    shown_apart = better is not None and with_bar(better, bar)[0] != with_bar(objective, bar)[0]
    if shown_apart and abs(better - objective) > last_digit:
        yield f"nearer to {with_bar(better, bar)[0]}: the objective with the estimate of its error added"


def _phase_line(name: str, phase: dict[str, Any]) -> str:
    """One phase: when it is, its mesh, its error."""
    time = phase["time"]
    when = f"t = {_number(time['initial'])} to {_number(time['final'])} {time['unit']}".rstrip()
    return f"{name}: {when}; {phase['method']}, {phase['segments']} segments; error {_eta(phase['relative_error'])}"


def _bounds(overshoot: dict[str, Any] | None, phases: dict[str, Any]) -> str:
    """How far bounds and path constraints are exceeded between the points, in their own unit."""
    if overshoot is None:
        return "none to hold"
    if overshoot["share"] is None:
        return "not known: a curve has no finite value"
    if overshoot["share"] <= HELD:
        return "held between the points"
    name, unit = overshoot["name"], f" {overshoot['unit']}" if overshoot["unit"] else ""
    verb = "are" if name.startswith("bounds") else "is"
    share = f"{100 * overshoot['share']:.2g} % of its range"
    when = f"t = {overshoot['time']:.4g}" + (f" of phase {overshoot['phase']}" if len(phases) > 1 else "")
    lasts = f", for {overshoot['lasts']:.2g} {phases[overshoot['phase']]['time']['unit']}" if overshoot["lasts"] else ""
    return f"{name} {verb} exceeded by {overshoot['amount']:.2g}{unit} ({share}) at {when}{lasts}".rstrip()


def _pairs(phases: dict[str, Any], several: bool) -> Iterator[str]:
    """How exact it is that one of two things is zero."""
    for phase, own in phases.items():
        for name, pair in own["complementarity"].items():
            when = f"t = {_number(pair['time'], 4)}" + (f" of phase {phase}" if several else "")
            yield f"{name}: a*b is {_number(pair['product'], 3)} at most, at {when}; relaxed to {pair['allowed']:.3g}"


def _reference(summary: dict[str, Any]) -> str:
    reference = summary["reference"]
    if not reference or not summary["solved"] or summary["objective"] is None:
        return ""
    if reference["agrees"] is None:
        return f"; {reference['objective']:.10g} is the reference of the file as it stands"
    if reference["agrees"]:
        return f"; agrees with the reference {reference['objective']:.10g}"
    return f"; differs from the reference {reference['objective']:.10g} by {reference['difference']:.2e}"


def _error(error: dict[str, Any], relative: float | None, several: bool) -> str:
    if error["max_eta"] is None:
        return "the dynamics have no finite value along the trajectory"
    segment = f"segment {error['segment']}" + (f" of phase {error['phase']}" if several else "")
    return (
        f"relative {_eta(relative)}; max eta {error['max_eta']:.2e}, in {error['state']} "
        f"on {segment}, t = {error['start']:.4g} to {error['end']:.4g}"
    )


def print_details(summary: dict[str, Any]) -> None:
    """The tables of `show`: every state, control and parameter, and every mesh."""
    summary = _rounded(summary)
    for name, phase in summary["phases"].items():
        _print_phase(name, phase)
    _print_prices(summary, "constraint between phases")
    print_correlation(summary["estimates"])
    print_arcs(summary["phases"])
    print()
    columns = ("", "method", "segments", "status", "objective", "+-", "max eta", "error", "iterations", "seconds")
    rows = [dict(zip(columns, _mesh_row(mesh), strict=True)) for mesh in summary["meshes"]]
    exact = all(phase["kind"] != CONTINUOUS for phase in summary["phases"].values())
    shown = [column for column in columns if not (exact and column in ("", "method", "segments", "max eta", "error"))]
    right = [column for column in shown if column not in ("method", "status")]
    print_table(shown, [[row[column] for column in shown] for row in rows], right)


def _print_phase(name: str, phase: dict[str, Any]) -> None:
    if phase["kind"] == STATIC:
        found = [(own, p["unit"], _number(p["value"], 10)) for own, p in phase["parameters"].items()]
        print()
        print_table(("", "unit", "value"), found, right=("value",))
        _print_prices(phase)
        return
    time, numbers = phase["time"], ("initial", "final", "min", "max")
    times = f"t = {_number(time['initial'])} to {_number(time['final'])} {time['unit']}"
    print(f"\n{one_line(f'phase {name}: {times}')}")
    rows = [
        (curve, value["unit"], *(_number(value[key]) for key in numbers), _eta(value.get("max_eta")))
        for kind in ("states", "controls", "algebraic", "outputs", "path")
        for curve, value in phase[kind].items()
    ]
    rows += [
        (parameter, p["unit"], _number(p["value"]), "", "", "", "") for parameter, p in phase["parameters"].items()
    ]
    print_table(("", "unit", *numbers, "max eta"), rows, right=(*numbers, "max eta"))
    _print_prices(phase)


def _print_prices(told: dict[str, Any], of: str = "constraint") -> None:
    """Of a phase, or of the whole result: then of what holds between phases."""
    if told["prices"]:
        rows = [(name, _number(value, 10)) for name, value in told["prices"].items()]
        print()
        print_table((of, "dJ/d bound"), rows, right=("dJ/d bound",))


def _mesh_row(mesh: dict[str, Any]) -> tuple[str, ...]:
    return (
        str(mesh["mesh"]),
        mesh["method"],
        str(mesh["segments"]),
        mesh["status"],
        _number(mesh["objective"], 10),
        cell(mesh["objective_error"], ".1e"),
        _eta(mesh["max_eta"]),
        _eta(mesh["relative_error"]),
        str(mesh["iterations"]),
        f"{sum(mesh['seconds'].values()):.3f}",
    )


def _eta(value: float | None) -> str:
    return cell(value, ".2e")


def _number(value: float | None, digits: int = 6) -> str:
    return "none" if value is None else f"{value:.{digits}g}"
