"""`trajopt check`, `export`, `init`: problem files and models."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

from ..common import build_checked, command, load_all, located
from ..options import Files, Force, Method, Segments, Set, overrides
from ..output.printing import one_line, plural


@command
def check(files: Files, *, set_: Set = ()) -> None:
    """Name every mistake in problem files, without solving.

    Example: trajopt check my_problem.yaml
    """
    specs = load_all(files, list(set_))
    build_checked(specs)
    for spec in specs:
        for warning in spec.warnings:
            print(f"warning: {one_line(str(warning))}", file=sys.stderr)
        counts = ((len(spec.states), "state"), (len(spec.controls), "control"), (len(spec.mesh), "mesh"))
        print(f"{spec.file}: no mistakes; " + ", ".join(plural(*count) for count in counts))


@command
def export(
    file: Annotated[str, typer.Argument(metavar="FILE|NAME", help="A problem file, or a name from 'trajopt list'.")],
    output: Annotated[Path, typer.Argument(metavar="OUT", help="out.nl, out.gms or out.tex")],
    *,
    set_: Set = (),
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
    from ...transcription.settings import steps

    problem = build(spec)
    with located(spec):
        paths = write(problem, [steps(spec.mesh)[-1].mesh()] * len(problem.phases), output, force)
    for path in paths:
        print(path)


@command
def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new problem; the file is NAME.yaml.")],
    *,
    source: Annotated[str, typer.Option("--from", metavar="NAME", help="Copy this shipped problem.")] = "template",
    force: Force = False,
) -> None:
    """Write a commented problem file to start from.

    Example: trajopt init my_problem --from cartpole
    """
    from ...problems.catalog import start_new

    path = start_new(name, source, force)
    print(f"{path}: edit it, then run: trajopt solve {path}")
