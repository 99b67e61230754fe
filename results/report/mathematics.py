"""The problem of a result as a reader wants to see it: equations in MathML, parameters with units and notes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any

from ...problems.expressions.tree import Number
from ...problems.lean.records import dataclass
from ...problems.names.symbols import Symbols
from ...problems.phases.merge import phase_specs
from ...problems.problem import Problem
from ...problems.schema.declarations import Parameter
from ...problems.schema.spec import Spec
from ...transcription.export.equations import EquationGroup, equations

if TYPE_CHECKING:
    from markupsafe import Markup

LONGEST = 20_000
"""Letters of LaTeX that are still shown as a formula; a longer one is text."""


@dataclass(frozen=True)
class Shown:
    """A group of equations, each with its lines in MathML or as text."""

    title: str
    equations: tuple[tuple[Any, ...], ...]
    left_out: int


@dataclass(frozen=True)
class Fixed:
    """A parameter. phase: that it belongs to, "" for all; value: its number; formula: what it is made of, or ""."""

    phase: str
    name: str
    value: float
    formula: str
    unit: str
    note: str


def shown_equations(spec: Spec, problem: Problem) -> list[Shown]:
    """The equations of a problem.

    spec: of its file.
    problem: built of it.
    """
    return [_shown(group) for group in equations(spec, problem)]


def _shown(group: EquationGroup) -> Shown:
    rows = [tuple(map(mathml, e.lines)) if e.lines else (e.words,) for e in group.equations]
    return Shown(group.title, tuple(rows), group.left_out)


def mathml(latex: str) -> Markup | str:
    """MathML of a line of `transcription.export.equations`; the line itself where that is too long."""
    from latex2mathml.converter import convert
    from markupsafe import Markup

    return Markup(convert(latex, display="block")) if len(latex) <= LONGEST else latex


def parameters(spec: Spec) -> list[Fixed]:
    """Every parameter of the file; what a phase has of its own is told apart."""
    rows: dict[tuple[str, float], list[tuple[str, Fixed]]] = {}
    specs = phase_specs(spec)
    for phase, own in specs.items():
        for fixed in _parameters(own):
            rows.setdefault((fixed.name, fixed.value), []).append((phase, fixed))
    return [_merged(alike, len(specs)) for alike in rows.values()]


def _merged(alike: list[tuple[str, Fixed]], phases: int) -> Fixed:
    names = "" if len(alike) == phases else ", ".join(phase for phase, _ in alike)
    own = alike[0][1]
    return Fixed(names, own.name, own.value, own.formula, own.unit, own.note)


def _parameters(spec: Spec) -> Iterator[Fixed]:
    numbers = Symbols(spec).numbers
    for name, parameter in spec.parameters.items():
        yield Fixed("", name, numbers[name], _formula(parameter), parameter.unit, parameter.note)


def _formula(parameter: Parameter) -> str:
    """The text of a value that is no plain number."""
    return "" if isinstance(parameter.value.root, Number) else parameter.value.text
