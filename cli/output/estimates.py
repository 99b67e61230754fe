"""Estimated parameters, for people: what `solve` and `show` print of a problem with measurements."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import combinations
from typing import Any

from .printing import cell, print_table

CLOSE = 0.98
"""A correlation worth telling: what is measured hardly tells the two parameters apart."""


def estimate_lines(found: dict[str, Any] | None) -> Iterator[tuple[str, str]]:
    """(name, text) of each line of the short table; found: of the summary, None without measurements."""
    if found is None:
        return
    for name, own in found["parameters"].items():
        unit = f" {own['unit']}" if own["unit"] else ""
        error, why = own["standard_error"], "" if found["missing"] else ", on a bound: taken as known"
        known = f" +- {cell(error, '.2g')}{unit}" if error is not None else f"{unit}{why}"
        yield "estimate", f"{name} = {cell(own['value'], '.6g')}{known}"
    count = f"{found['measurements']} measurements, {found['free']} unknown{'s' * (found['free'] != 1)}"
    if found["missing"]:
        yield "fit", f"{count}; no standard errors: {found['missing']}"
        return
    over = found["measurements"] - found["free"]
    each = f", {found['residuals'] / over:.3g} for each beyond the unknowns" if over > 0 else ""
    scale = "" if found["given"] else f"; standard deviation {found['scale']:.3g} (of weight 1)"
    yield "fit", f"{count}; sum of squares {found['residuals']:.6g}{each}{scale}"
    for a, b in combinations(found["correlation"], 2):
        if (value := found["correlation"][a][b]) is not None and abs(value) > CLOSE:
            yield "correlation", f"{a} and {b}: {value:.4f}, so that they are hardly told apart"


def print_correlation(found: dict[str, Any] | None) -> None:
    """The matrix of correlations, for `show`; found: of the summary, None without measurements."""
    if found is None or found["missing"] or len(found["correlation"]) < 2:
        return
    print("\ncorrelation of the estimates")
    names = list(found["correlation"])
    rows = [(name, *(cell(found["correlation"][name][other], ".4f") for other in names)) for name in names]
    print_table(("", *names), rows, right=names)
