"""Whether the solution of a mesh is to be believed, and whether a finer mesh can help."""

from __future__ import annotations

import numpy as np

from ..solution.solution import Solution
from ..solution.violation import of_phase

UNTRUE = 10.0
"""Times the error of the mesh before: with as much on a finer one, a better objective is not believed."""


STANDING, NOTICED, LEAST = 0.8, 0.25, 1e-4
"""An error bar stands if it is more than that of the bar of the mesh before; what other controls gain is told if it is
more than a part of the bar, and of 1 + |J|."""


def left_basin(before: Solution, after: Solution) -> bool:
    """Whether the objective of a finer mesh has moved by more than both error bars, and not for the better.

    Then it belongs to another optimum: on one and the same, both bars hold the exact value. A gain is none where the
    error of the dynamics has grown with it: the scheme's equations have solutions that follow no dynamics.
    """
    if not after.status.usable or not (before.objective_error.applies and after.objective_error.applies):
        return False
    loss = before.problem.sense * (after.objective - before.objective)
    untrue = after.meshes[-1].relative_error > UNTRUE * before.meshes[-1].relative_error
    return (abs(loss) if untrue else loss) > before.objective_error.bar + after.objective_error.bar


def unmeasurable(solution: Solution) -> str:
    """Why no refinement can help: residuals that do not determine the rates leave no error to measure; or ""."""
    implicit = [e for t, e in zip(solution.trajectories, solution.errors, strict=True) if t.phase.algebraic]
    if any(not np.isfinite(error.relative).any() for error in implicit):
        return "the residuals do not determine the rates (index above 1), so the error cannot be estimated"
    return ""


def unminimised(solution: Solution) -> str:
    """Where other controls have a lower Hamiltonian, however fine the mesh; "" if the error bar falls with the mesh.

    Such a solution is stationary, but no minimum of Pontryagin's: where H is concave in a control, its optimum switches
    between two values ever faster, and no mesh holds that.

    solution: of the last mesh, with the history of all.
    """
    bars = [mesh.objective_error for mesh in solution.meshes]
    if len(bars) < 2 or not solution.objective_error.applies or not bars[-1] > STANDING * bars[-2]:
        return ""
    worst, most = "", NOTICED * solution.objective_error.bar
    for trajectory, lost in zip(solution.trajectories, solution.objective_error.terms["control"], strict=True):
        amount, total = np.abs(lost), float(np.abs(lost).sum())
        if total <= most or total < LEAST * (1 + abs(solution.objective)):
            continue
        bearing = np.flatnonzero(amount > amount.max() / 10)
        start, end = trajectory.knots[bearing[0]], trajectory.knots[bearing[-1] + 1]
        most = total
        worst = (
            f"the error bar does not fall with the mesh: within t = {start:.4g} to {end:.4g}"
            f"{of_phase(trajectory.phase.name)} another control has a lower Hamiltonian; this solution is stationary, "
            "but a control that switches ever faster (chattering) may be better"
        )
    return worst
