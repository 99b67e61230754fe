"""Why a phase or a mesh is none for collocation, or for finite differences: asked of every file, without Pyomo."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from ...problems.errors import Mistake
from ...problems.problem import Phase, Problem
from ..method_kind import no_delays
from ..schemes.mesh import Mesh
from ..schemes.scheme import collocation_scheme


def refused_by_collocation(problem: Problem, phase: Phase, mesh: Mesh) -> Iterable[Mistake]:
    """Why a phase or a mesh is none for collocation.

    problem: not looked at; all methods are asked with the same arguments.
    phase: its states at earlier times need a value at every node of the segments.
    mesh: of collocation schemes.
    """
    eliminated = [scheme.name for scheme in mesh.schemes if collocation_scheme(scheme).eliminated]
    if phase.delayed and eliminated:
        what = (
            f"{eliminated[0]} has no unknowns in the middle of a segment, where {phase.delayed[0].name} looks for them"
        )
        yield Mistake("mesh", what, "write hermite-simpson, or another collocation method")


def refused_by_differences(problem: Problem, phase: Phase, mesh: Mesh) -> Iterator[Mistake]:
    """Why a phase or a mesh is none for finite differences.

    problem: none with states at earlier times.
    phase: its states must be positions with a second derivative, and their velocities.
    mesh: must have two or more segments, all of one width.
    """
    yield from no_delays(problem, "finite-difference")
    if phase.measured:
        what = "finite differences have no velocities among their unknowns, and no knots where something is measured"
        yield Mistake("mesh", what, "take another method, such as radau or hermite-simpson")
    positions = {state.velocity_of for state in phase.states}
    alone = [state.name for state in phase.states if state.name not in positions and not state.velocity_of]
    if alone:
        what = f"finite-difference needs second-order dynamics, and '{alone[0]}' has none"
        yield Mistake(
            "mesh", what, f"give '{alone[0]}' accel: instead of rate:, or take another method; so for a named integral"
        )
    if mesh.segments < 2 or np.ptp(mesh.widths) > 1e-12:
        what = "finite-difference needs two or more equal segments"
        yield Mistake("mesh", what, "give segments: as a number, or take another method")
