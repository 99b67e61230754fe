"""`trajopt export`: the nonlinear program for other solvers, or to read."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from ...transcription.loading import load_all, located
from ..errors import command
from ..options import Force, Method, Segments, Set, overrides


@command
def export(
    file: Annotated[str, typer.Argument(metavar="FILE|NAME", help="A problem file, or a name from 'trajopt list'.")],
    output: Annotated[Path, typer.Argument(metavar="OUT", help="out.nl, out.gms or out.tex")],
    *,
    set_: Set = None,
    method: Method = None,
    segments: Segments = None,
    force: Force = False,
) -> None:
    """Write the nonlinear program for other solvers, or to read.

    Example: trajopt export cartpole cartpole.nl --segments 10

    The suffix of OUT chooses the format: .nl (AMPL, with the names in .row and .col), .gms (GAMS) or .tex (LaTeX). The
    program is that of the last mesh of the schedule, before any refinement.
    """
    (spec,) = load_all([file], overrides(set_, method, segments))

    from ...problems.build import build
    from ...transcription.export.export import export as write
    from ...transcription.settings import schedule_of
    from ...transcription.solve import meshes_of

    problem = build(spec)
    with located(spec):
        paths = write(problem, meshes_of(problem, schedule_of(spec)[-1]), output, force)
    for path in paths:
        print(path)
