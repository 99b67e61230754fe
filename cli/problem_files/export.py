"""`trajopt export`: the nonlinear program for other solvers, or to read; the problem file of a result."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Annotated

import typer

from ...problems.catalog import shipped
from ...problems.errors import Mistake, SpecError
from ...transcription.loading import load_all, located
from ..errors import command
from ..options import Force, Method, Segments, Set, overrides

TABLES = (".csv", ".parquet")


@command
def export(
    file: Annotated[
        str,
        typer.Argument(metavar="FILE|NAME", help="A problem file, or a name from 'trajopt list'; a result for .yaml."),
    ],
    output: Annotated[Path, typer.Argument(metavar="OUT", help="out.nl, out.gms, out.tex or out.yaml")],
    *,
    set_: Set = None,
    method: Method = None,
    segments: Segments = None,
    force: Force = False,
) -> None:
    """Write the nonlinear program, or the problem file of a result.

    Example: trajopt export cartpole cartpole.nl --segments 10

    Example: trajopt export cartpole.h5 as_solved.yaml

    The suffix of OUT chooses the format: .nl (AMPL, with the names in .row and .col), .gms (GAMS) or .tex (LaTeX). The
    program is that of the last mesh of the schedule, before any refinement. With .yaml it is the problem file of a
    result, as it was solved: with the overrides, and after --polish with the phases that it made.
    """
    if output.suffix in (".yaml", ".yml"):
        _write_problem(file, output, force, [*(set_ or ()), *filter(None, (method, segments))])
        return
    if Path(file).suffix == ".h5" and output.suffix in TABLES:
        what = "the curves of a result are written by another command"
        raise SpecError(Mistake(str(output), what, f"write trajopt table {file} -o {output}"))
    (spec,) = load_all([file], overrides(set_, method, segments))

    from ...problems.build import build
    from ...transcription.export.export import check_format
    from ...transcription.export.export import export as write
    from ...transcription.settings import meshes_of, schedule_of

    check_format(output)
    problem = build(spec)
    with located(spec):
        paths = write(problem, meshes_of(problem, schedule_of(spec)[-1]), output, force)
    for path in paths:
        print(path)


def _write_problem(file: str, output: Path, force: bool, changed: Sequence[object]) -> None:
    from ...results.problem_text import write_problem

    source = Path(file)
    if changed:
        raise SpecError(Mistake(str(output), "a problem file is written as it was solved", "change it there"))
    if source.suffix != ".h5" and not source.exists():
        remedy = f"write trajopt init {output} --from {file}" if file in shipped() else "give a result, such as out.h5"
        raise SpecError(Mistake(str(output), ".yaml is for the problem file of a result", remedy))
    write_problem(source, output, force)
    print(output)
