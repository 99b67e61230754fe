"""Summaries for people: the tables at the end of `solve` and of `show`."""

from __future__ import annotations

from typing import Any

import typer

from .common import print_table


def print_summary(summary: dict[str, Any]) -> None:
    """The short table: status, objective, error, iterations, seconds by part, file; and what to do if it failed."""
    solved = summary["solved"]
    title = f"{summary['problem']}: {'solved' if solved else 'NOT SOLVED'}"
    typer.secho(title, bold=True, fg="green" if solved else "red")
    for name, text in _rows(summary):
        print(f"{name:<12}{text}")


def _rows(summary: dict[str, Any]):
    if not summary["solved"]:
        yield "status", summary["message"]
        for violation in summary["violations"][:3]:
            yield "cause", violation
        if summary["trouble"]:
            yield "cause", summary["trouble"]
        yield "remedy", summary["remedy"]
    yield "objective", f"{_number(summary['objective'], 10)}  ({summary['sense']}){_reference(summary)}"
    yield "error", _error(summary["error"])
    mesh = summary["meshes"][-1]
    yield "mesh", f"{mesh['method']}, {mesh['segments']} segments, {mesh['unknowns']} unknowns"
    count = len(summary["meshes"])
    yield "iterations", f"{summary['iterations']}" + (f" on {count} meshes" if count > 1 else "")
    parts = ", ".join(f"{part.replace('_', ' ')} {value:.3f}" for part, value in summary["seconds"].items() if part != "total")
    yield "seconds", f"{summary['seconds']['total']:.3f}  ({parts})"
    yield "file", summary["file"]


def _reference(summary: dict[str, Any]) -> str:
    reference = summary["reference"]
    if not reference or not summary["solved"]:
        return ""
    if reference["agrees"]:
        return f"; agrees with the reference {reference['objective']:.10g}"
    return f"; differs from the reference {reference['objective']:.10g} by {reference['difference']:.2e}"


def _error(error: dict[str, Any]) -> str:
    if error["max_eta"] is None:
        return "the dynamics have no finite value along the trajectory"
    return (
        f"max eta {error['max_eta']:.2e}, in {error['state']} "
        f"on segment {error['segment'] + 1}, t = {error['start']:.4g} to {error['end']:.4g}"
    )


def print_details(summary: dict[str, Any]) -> None:
    """The tables of `show`: every state, control and parameter, and every mesh."""
    numbers = ("initial", "final", "min", "max")
    for name, phase in summary["phases"].items():
        time = phase["time"]
        print(f"\nphase {name}: t = {_number(time['initial'])} to {_number(time['final'])} {time['unit']}")
        rows = [
            (curve, value["unit"], *(_number(value[key]) for key in numbers), _eta(value.get("max_eta")))
            for kind in ("states", "controls")
            for curve, value in phase[kind].items()
        ]
        rows += [(parameter, "", _number(value), "", "", "", "") for parameter, value in phase["parameters"].items()]
        print_table(("", "unit", *numbers, "max eta"), rows, right=(*numbers, "max eta"))
    print()
    columns = ("mesh", "method", "segments", "status", "objective", "max eta", "iterations", "seconds")
    rows = [
        (
            str(number), mesh["method"], str(mesh["segments"]), mesh["status"], _number(mesh["objective"], 10),
            _eta(mesh["max_eta"]), str(mesh["iterations"]), f"{sum(mesh['seconds'].values()):.3f}",
        )  # fmt: skip
        for number, mesh in enumerate(summary["meshes"], start=1)
    ]
    print_table(columns, rows, right=[column for column in columns if column not in ("method", "status")])


def _eta(value: float | None) -> str:
    return "" if value is None else f"{value:.2e}"


def _number(value: float | None, digits: int = 6) -> str:
    return "none" if value is None else f"{value:.{digits}g}"
