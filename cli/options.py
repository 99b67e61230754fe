"""Arguments and options that several commands share, each declared once."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

SHORT_FORMS = {
    "mesh.*.method": "--method",
    "mesh.-1.segments": "--segments",
    "mesh.-1.tolerance": "--tol",
    "refine.tolerance": "--refine",
    "solver.seconds": "--time-limit",
    "refine.objective": "--accuracy",
    "solver.starts": "--starts",
    "solver.seed": "--seed",
}
"""Options that stand for an override, by its path; messages name the option."""

_NAMES = "Problem files, or names from 'trajopt list'."
Files = Annotated[list[str], typer.Argument(metavar="FILE|NAME...", help=_NAMES, show_default=False)]
_WRITTEN = "Result files of 'trajopt solve'."
Results = Annotated[list[Path], typer.Argument(metavar="RESULT...", help=_WRITTEN, show_default=False, readable=False)]
Set = Annotated[
    list[str] | None, typer.Option("--set", metavar="PATH=VALUE", help="Override a field of the problem file.")
]
Method = Annotated[str | None, typer.Option("--method", metavar="METHOD", help="Method, on every mesh.")]
Segments = Annotated[
    str | None, typer.Option("--segments", metavar="N", help="Segments of the last mesh; refinement starts on it.")
]
Json = Annotated[bool, typer.Option("--json", help="Print JSON, one object on each line, in place of tables.")]
Quiet = Annotated[bool, typer.Option("-q", "--quiet", help="Print nothing but errors.")]
Picture = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Name of the picture, or a folder.")
]
Force = Annotated[bool, typer.Option("--force", help="Replace an existing file, whatever it holds.")]


def overrides(
    set_: Sequence[str] | None,
    method: str | None = None,
    segments: str | None = None,
    tol: str | None = None,
    refine: str | None = None,
    time_limit: str | None = None,
    accuracy: str | None = None,
    starts: str | None = None,
    seed: str | None = None,
) -> list[str]:
    """The short forms as overrides, after those of --set; they are checked as these are."""
    values = (method, segments, tol, refine, time_limit, accuracy, starts, seed)
    return [*(set_ or ()), *(f"{path}={v}" for path, v in zip(SHORT_FORMS, values, strict=True) if v is not None)]
