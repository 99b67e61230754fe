"""The nonlinear program as a file for other solvers, or for reading.

Pyomo's writers take ordinary models, not templated ones, so the same builder builds the model expanded. Pyomo's printer
of LaTeX would write it with sums and quantifiers over Sets again: `latex` writes every equation out.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from contextlib import ExitStack
from io import StringIO
from pathlib import Path

from ...problems.errors import Mistake, SpecError
from ...problems.files import check_writable, replacing
from ...problems.names.lookups import tables_of
from ...problems.problem import Problem
from ..layout import Transcription
from ..schemes.mesh import Mesh
from ..transcribe import transcribe
from . import latex

FORMATS = (".nl", ".gms", ".tex")
NL_HEADER = 10  # lines


def check_format(path: Path) -> None:
    """Raise SpecError for a file whose suffix tells no format."""
    if path.suffix not in FORMATS:
        what = f"'{path.suffix}' is no format of 'trajopt export'" if path.suffix else "the name has no suffix"
        remedy = (
            f"end the name with one of {', '.join(FORMATS)}; curves of a result are written by trajopt table, .csv, "
            "and its problem file with .yaml"
        )
        raise SpecError(Mistake(str(path), what, remedy))


def export(problem: Problem, meshes: Sequence[Mesh], path: Path, force: bool = False) -> list[Path]:
    """Write the expanded model to a file; returns the files written.

    problem: transcribed with its own guess.
    meshes: one for each phase.
    path: the suffix says the format: AMPL's .nl, GAMS's .gms, or LaTeX's .tex. Beside a .nl file stand .row and .col,
        the names of its constraints and variables.
    force: whether existing files are replaced.

    Raises SpecError for another suffix, FileError if a file exists and not `force`, or cannot be written.
    """
    check_format(path)
    written = [path, *(path.with_suffix(suffix) for suffix in (".row", ".col") if path.suffix == ".nl")]
    tables = tables_of(problem)
    if path.suffix != ".tex" and tables:
        what = f"the table {tables[0]} cannot be written to {path.suffix}, whose formulas have no tables of data"
        remedy = "end the name with .tex, or write a formula in place of the table"
        raise SpecError(Mistake(str(path), what, remedy))
    for target in written:
        check_writable(target, force)
    expanded = transcribe(problem, meshes, templates=False)
    {".nl": _write_nl, ".gms": _write_gams, ".tex": _write_latex}[path.suffix](expanded, written)
    return written


def _write_nl(expanded: Transcription, targets: Sequence[Path]) -> None:
    from pyomo.repn.plugins.nl_writer import NLWriter

    text, model = StringIO(), expanded.model
    model.name = " ".join(expanded.problem.name.split())  # it stands in a comment, at the end of the first line
    with ExitStack() as stack:
        paths = [stack.enter_context(replacing(target)) for target in targets]
        streams = [stack.enter_context(path.open("w", encoding="utf-8", newline="")) for path in paths]
        NLWriter().write(model, text, *streams[1:], symbolic_solver_labels=True, linear_presolve=False)
        *header, body = text.getvalue().split("\n", NL_HEADER)
        # AMPL's own library skips Pyomo's comments; CasADi stops at them.
        streams[0].write("\n".join([*header, re.sub(r"[ \t]*#.*", "", body)]))


def _write_gams(expanded: Transcription, targets: Sequence[Path]) -> None:
    import pyomo.environ  # noqa: F401  (registers the writers)

    with replacing(targets[0]) as temporary:
        expanded.model.write(str(temporary), format="gams", io_options={"symbolic_solver_labels": True})


def _write_latex(expanded: Transcription, targets: Sequence[Path]) -> None:
    with replacing(targets[0]) as temporary, temporary.open("w", encoding="utf-8") as stream:
        latex.write_latex(expanded, stream)
