"""`trajopt check`: every mistake in problem files, without solving."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from typing import TYPE_CHECKING

from ...transcription.loading import build_checked, load_all
from ..errors import command
from ..options import Files, Quiet, Set, overrides
from ..output.printing import one_line, plural
from ..streams import piped_text

if TYPE_CHECKING:  # `trajopt --help` imports this module; it needs no pydantic
    from ...problems.schema.spec import Spec


@command
def check(files: Files, *, set_: Set = None, quiet: Quiet = False) -> None:
    """Name every mistake in problem files, without solving.

    Example: trajopt check my_problem.yaml
    """
    specs = load_all(files, overrides(set_), piped_text(files), units=True)
    build_checked(specs)
    for spec in specs if not quiet else ():
        for warning in spec.warnings:
            print(f"warning: {one_line(str(warning))}", file=sys.stderr)
        print(f"{spec.file}: no mistakes; " + ", ".join(plural(*count) for count in _counts(spec)))


def _counts(spec: Spec) -> Iterator[tuple[int, str]]:
    """How many there are of what: of states and controls the most that a phase has."""
    from ...problems.names import variables
    from ...problems.phases.merge import phase_specs

    phases = list(phase_specs(spec).values())
    if len(phases) > 1:
        yield len(phases), "phase"
    yield max(len(variables.states(phase)) for phase in phases), "state"
    yield max(len(variables.controls(phase)) for phase in phases), "control"
    yield len(phases[0].mesh), "mesh"
