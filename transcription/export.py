"""The nonlinear program as a file for other solvers, or for reading.

Pyomo's writers take ordinary models, not templated ones, so the same builder builds the model expanded.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import ExitStack
from pathlib import Path

from ..problems.errors import Mistake, SpecError
from ..problems.files import check_writable, replacing
from ..problems.problem import Problem
from .mesh import Mesh
from .transcribe import transcribe

FORMATS = (".nl", ".gms", ".tex")


def export(problem: Problem, meshes: Sequence[Mesh], path: Path, force: bool = False) -> list[Path]:
    """Write the expanded model to path: AMPL's .nl, GAMS's .gms, or LaTeX's .tex, by its suffix.

    Beside a .nl file stand .row and .col, the names of its constraints and variables. Returns the files written.
    Raises SpecError for another suffix, FileError if a file exists and not `force`, or cannot be written.
    """
    if path.suffix not in FORMATS:
        what = f"'{path.suffix}' is no format of 'trajopt export'" if path.suffix else "the name has no suffix"
        raise SpecError(Mistake(str(path), what, f"end the name with one of {', '.join(FORMATS)}"))
    written = [path, *(path.with_suffix(suffix) for suffix in (".row", ".col") if path.suffix == ".nl")]
    for target in written:
        check_writable(target, force)
    model = transcribe(problem, meshes, templates=False).model
    {".nl": _write_nl, ".gms": _write_gams, ".tex": _write_latex}[path.suffix](model, written)
    return written


def _write_nl(model, targets: Sequence[Path]) -> None:
    from pyomo.repn.plugins.nl_writer import NLWriter

    with ExitStack() as stack:
        streams = [stack.enter_context(stack.enter_context(replacing(t)).open("w", newline="")) for t in targets]
        NLWriter().write(model, *streams, symbolic_solver_labels=True, linear_presolve=False)


def _write_gams(model, targets: Sequence[Path]) -> None:
    import pyomo.environ  # noqa: F401  (registers the writers)

    with replacing(targets[0]) as temporary:
        model.write(str(temporary), format="gams", io_options={"symbolic_solver_labels": True})


def _write_latex(model, targets: Sequence[Path]) -> None:
    from pyomo.contrib.latex_printer import latex_printer

    with replacing(targets[0]) as temporary, temporary.open("w") as stream:
        latex_printer(model, ostream=stream)
