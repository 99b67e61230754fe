"""abs, min and max made consistent: solved problems."""

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.transcription.settings import steps

from .nonsmooth_files import REST, loaded, result, text


def control(solution, name: str) -> np.ndarray:
    (trajectory,) = solution.trajectories
    names = [variable.name for variable in trajectory.phase.inputs]
    return trajectory.u[names.index(name)]


def test_minimum_work_with_slack_variables():
    solution = result(load(shipped()["block_move_min_work"]))
    assert f"{solution.objective:.5f}" == "1.10651"


def test_minimum_work_along_a_smoothing_schedule():
    solution = result(load(shipped()["block_move_min_work_smooth"]))
    assert [f"{mesh.objective:.5f}" for mesh in solution.meshes] == ["0.64588", "1.03092", "1.10574"]


@pytest.mark.parametrize(("alpha", "printed"), [("5", "0.64588"), ("1", "1.03092")])
def test_minimum_work_by_one_width(alpha, printed):
    spec = load(shipped()["block_move_min_work_smooth"], [f"nonsmooth.tanh={alpha}"])
    mesh = steps(spec.mesh)[:1]
    assert f"{result(spec, mesh).objective:.5f}" == printed


def test_the_two_smooth_functions_enclose_the_exact_one():
    """tanh is below |y| and the square root is above it, so the optima are too (paper, 8.6)."""
    name = "block_move_min_work_smooth"
    objectives = {}
    for kind in ("tanh", "sqrt"):
        spec = load(shipped()[name], [f"nonsmooth={{{kind}: [5, 1, 0.1]}}"])
        objectives[kind] = result(spec).objective
    assert objectives["tanh"] < 1.10651 < objectives["sqrt"]


def test_minimum_work_tends_to_the_exact_value():
    errors = []
    for segments in (50, 100, 200):
        spec = load(shipped()["block_move_min_work"], [f"mesh.0.segments={segments}"])
        errors.append(1.1145618 - result(spec).objective)
    assert errors[0] > errors[1] > errors[2] > 0 and errors[2] < 3e-3


def test_a_bound_on_abs_is_the_two_bounds():
    plain = result(loaded(ends=REST, constraints="path: [{expression: v, lower: -1.2, upper: 1.2}]"))
    slack = result(loaded(ends=REST, constraints="path: [{expression: abs(v), upper: 1.2}]"))
    assert slack.objective == pytest.approx(plain.objective, rel=1e-6)
    assert control(slack, "abs1_plus") - control(slack, "abs1_minus") == pytest.approx(
        slack.trajectories[0].x[1], abs=1e-6
    )


def test_a_maximised_minimum():
    """The largest smallest velocity that covers a distance of 1 in 1 s is 1."""
    spec = loaded(expressions="slowest: 'min(p, 2)'", objective="maximize: {terminal: slowest}",
                  constraints="path: [{expression: v - p, lower: 0}]")  # fmt: skip
    assert result(spec).objective == pytest.approx(1, abs=1e-6)


def test_slack_in_dynamics_and_smoothing_agree():
    """Quadratic drag in both directions, v' = u - |v| v."""
    smooth = result(loaded(nonsmooth="{tanh: 0.001}", rate="u - abs(v)*v", ends=REST))
    slack = result(loaded(nonsmooth="slack", rate="u - abs(v)*v", ends=REST))
    assert slack.objective == pytest.approx(smooth.objective, rel=1e-4)


def test_a_terminal_cost_of_abs_at_the_ends():
    spec = loaded(objective="minimize: {terminal: 'abs(v[final] + 1) + abs(v[initial] - 2)', integral: 'w + p**2'}")
    solution = result(spec)
    assert solution.objective == pytest.approx(0, abs=1e-6)
    assert solution.trajectories[0].x[1, [0, -1]] == pytest.approx([2, -1], abs=1e-6)


def test_refused_without_a_way():
    with pytest.raises(SpecError) as error:
        load_text(text(nonsmooth="slack", rate="u - abs(v)").replace("nonsmooth: slack\n", ""), "file.yaml")
    (mistake,) = error.value.mistakes
    assert mistake.where == "file.yaml:7: states.v.rate"
    assert all(way in mistake.remedy for way in ("slack", "{tanh: 0.01}", "{sqrt: 0.01}"))


def test_abs_of_a_constant_needs_no_way():
    spec = load_text(text(rate="u + max(k, n)*v").replace("nonsmooth: slack\n", ""), "file.yaml")
    assert build(spec).phases[0].states[1].rate({"u": 1.0, "v": 3.0}, np) == 7.0
