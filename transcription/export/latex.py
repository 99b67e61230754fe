r"""The nonlinear program as a LaTeX document: the objective, every constraint and all bounds, written out.

    state q1 at point 3                  x_{q1,3}
    control u at point 3                 u_{u,3}
    algebraic variable a at point 3      z_{a,3}
    initial and final time               t_0, t_F
    static parameter m                   p_m

Points count from 0, as in the paper: x_0 is the initial state. Segments count from 1, as in tables and messages. With
several phases the name of the phase is one more subscript.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import groupby
from typing import Any, TextIO

import numpy as np

from ..constraint_kinds import DEFECT
from ..layout import Family, Transcription
from ..schemes.mesh import Mesh
from ..solution.violation import of_phase
from .formula import AT_MOST, EQUAL, Formula, Piece, Printer, lines, related, tex_name, tex_number

HEAD = r"""\documentclass{article}
\usepackage{amsmath}
\usepackage[a4paper, margin=15mm]{geometry}
\setlength{\parindent}{0pt}
\allowdisplaybreaks
\begin{document}
"""

SPECIAL = str.maketrans(
    {
        "\\": r"\textbackslash{}",
        "~": r"\textasciitilde{}",
        "^": r"\textasciicircum{}",
        **{c: "\\" + c for c in "{}$&#%_"},
        **{c: f"${c}$" for c in "<>|"},
    }
)
LAST_KNOWN = "\u017f"  # pdflatex knows the accented Latin letters, which end here, and stops at others


def write_latex(transcription: Transcription, stream: TextIO) -> None:
    """Write an expanded transcription (see `transcribe`) as a document that pdflatex takes."""
    document = _Document(transcription, stream)
    stream.write(HEAD)
    document.summary()
    document.objective()
    document.constraints()
    document.bounds()
    stream.write("\\end{document}\n")


def escaped_tex(text: str) -> str:
    """Any text on one line; what pdflatex does not know by its number in Unicode."""
    known = "".join(c if c <= LAST_KNOWN else f"(U+{ord(c):04X})" for c in " ".join(text.split()))
    return known.translate(SPECIAL)


class _Document:
    def __init__(self, transcription: Transcription, stream: TextIO) -> None:
        self.transcription, self.stream = transcription, stream
        self.variables = list(_variables(transcription))
        self.formula_of = Printer(
            {
                id(variable): _name(symbol, subscripts, k)
                for symbol, subscripts, variables in self.variables
                for k, variable in variables.items()
            }
        )

    def summary(self) -> None:
        constraints = sum(len(family.span) for family in self.transcription.families)
        self.stream.write(f"\\section*{{{escaped_tex(self.transcription.problem.name)}}}\n")
        self.stream.write(f"{len(self.transcription.variables)} unknowns, {constraints} constraints.\n")
        for layout in (layout for layout in self.transcription.phases if not layout.phase.static):
            mesh = layout.mesh
            methods = ", ".join(dict.fromkeys(scheme.name for scheme in mesh.schemes))
            self.stream.write(
                f"Phase {escaped_tex(layout.phase.name)}: {methods}; segments 1 to {mesh.segments}, "
                f"points 0 to {len(mesh.fractions) - 1}.\n"
            )

    def section(self, title: str) -> None:
        self.stream.write(f"\n\\subsection*{{{title}}}\n")

    def formulas(self, formulas: Sequence[Formula]) -> None:
        rows = " \\\\\n& ".join(" \\\\\n& \\quad {}".join(lines(formula)) for formula in formulas)
        self.stream.write(f"\\begin{{align*}}\n& {rows}\n\\end{{align*}}\n")

    def objective(self) -> None:
        self.section("Objective, to be minimised")
        self.formulas([self.formula_of(self.transcription.model.cost.expr)])

    def constraints(self) -> None:
        self.section("Constraints")
        meshes = {layout.phase.name: layout.mesh for layout in self.transcription.phases}
        for family in self.transcription.families:
            labels = _labels(family, meshes.get(family.phase))
            for label, constraint in zip(labels, list(family.component.values())[family.part], strict=True):
                self.stream.write(f"{label}\n")
                self.formulas([self.formula_of(constraint.expr)])

    def bounds(self) -> None:
        self.section("Unknowns and bounds")
        rows: list[Formula] = []
        for symbol, subscripts, variables in self.variables:
            alike: dict[tuple[Any, Any], list] = {}
            for k, variable in variables.items():
                ends = (variable.value, variable.value) if variable.fixed else variable.bounds
                alike.setdefault(ends, []).append(k)
            rows += [_bounds(symbol, subscripts, low, high, points) for (low, high), points in alike.items()]
        self.formulas(rows)


def _variables(transcription: Transcription) -> Iterator[tuple[str, tuple[str, ...], dict[int | None, Any]]]:
    """(symbol, subscripts but for the point, point -> variable), the point None for what has none."""
    model, phases = transcription.model, transcription.phases
    for layout in (layout for layout in phases if not layout.phase.static):
        block, phase = model.phase[layout.phase.name], (layout.phase.name,) if len(phases) > 1 else ()
        yield "t", ("0", *phase), {None: block.t0}
        yield "t", ("F", *phase), {None: block.tF}
        for symbol in ("x", "u", "z"):
            by_name = groupby(getattr(block, symbol, {}).items(), key=lambda item: item[0][0])
            for own, items in by_name:
                yield symbol, (*phase, own), {k: variable for (_, k), variable in items}
    for parameter in transcription.problem.parameters:
        yield "p", (parameter.name,), {None: model.p[parameter.name]}


def _name(symbol: str, subscripts: tuple[str, ...], k: int | str | None) -> Formula:
    return tex_name(symbol, *subscripts) if k is None else tex_name(symbol, *subscripts, str(k))


def _labels(family: Family, mesh: Mesh | None) -> Iterator[str]:
    """What each constraint of a family is, and where it holds; a link belongs to no mesh."""
    what = " ".join(
        filter(None, [family.kind.heading.format(escaped_tex(family.name)), escaped_tex(of_phase(family.phase))])
    )
    rows = mesh.groups[family.group].scheme.rows if mesh and family.kind is DEFECT else ()
    for start, end in family.span:
        if not family.kind.timed or mesh is None:
            yield what
        elif start == end:
            yield f"{what}, point {np.searchsorted(mesh.fractions, start)}"
        else:
            row = f", row {rows.index(family.row) + 1} of {len(rows)}" if len(rows) > 1 else ""
            yield f"{what}, segment {np.searchsorted(mesh.edges, start) + 1}{row}"


def _bounds(symbol: str, subscripts: tuple[str, ...], lower: Any, upper: Any, points: list) -> Formula:
    """One line for all points with the same bounds."""
    variable = _name(symbol, subscripts, points[0] if len(points) == 1 else "k")
    if lower is None and upper is None:
        relation = variable.before(Piece(r" \text{ free}", 4.0))
    elif lower == upper:
        relation = related(EQUAL, variable, tex_number(lower))
    else:
        ends = [None if end is None else tex_number(end) for end in (lower, upper)]
        relation = related(AT_MOST, *(side for side in (ends[0], variable, ends[1]) if side is not None))
    if len(points) == 1:
        return relation
    *runs, last = _runs(points)
    first, *rest = [Piece(f"{run},", len(run)) for run in runs] + [Piece(last, len(last))]
    return Formula((*relation.before(Piece(r",\quad k = ", 6.0) + first).pieces, *rest))


def _runs(points: list[int]) -> Iterator[str]:
    """The points, four or more in equal steps as "0, 2, \\dots, 20"."""
    i = 0
    while i < len(points):
        j = i + 1
        while j < len(points) and points[j] - points[j - 1] == points[i + 1] - points[i]:
            j += 1
        if j - i < 4:
            yield f"{points[i]}"
            i += 1
            continue
        yield rf"{points[i]}, {points[i + 1]}, \dots, {points[j - 1]}"
        i = j
