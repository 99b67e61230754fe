"""abs, min and max in a solution that is solved again in phases: slack variables written out, and kinks that stay."""

from functools import cache

import numpy as np
import pytest
import yaml
from named import share

from trajopt.problems.expressions.expression import parse
from trajopt.problems.nonsmooth.spelled import spelled
from trajopt.problems.nonsmooth.written import with_slack
from trajopt.problems.phases.split import why_not
from trajopt.problems.quantities import Range
from trajopt.results.file.write import write
from trajopt.results.polish.polish import polish
from trajopt.results.polish.signs import worth_of_leaving
from trajopt.results.verify import verify
from trajopt.transcription.arcs import LOWER
from trajopt.transcription.loading import load_yaml

from .polished import first

MOVE = """\
trajopt: 1
name: rest to rest
time: {initial: 0, final: 3}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {integral: "WORK"}}
nonsmooth: slack
"""
FASTEST = (3 - 5**0.5) / 2  # w (T - w) = 1: the speed between full thrust and full brake
PUSH = 1 / 2 - 1 / 5**0.5  # of the shipped block: u_max t*, over u_max = 20

EXACT = [
    ("block_move_min_work", (20 * PUSH) ** 2, 1e-9),
    (MOVE.replace("WORK", "abs(u)"), 2 * FASTEST, 1e-10),
    (MOVE.replace("WORK", "max(u, 0)"), FASTEST, 1e-10),
    (MOVE.replace("WORK", "max(u, -u, 0)"), 2 * FASTEST, 1e-9),
    (
        MOVE.replace("WORK", "thrust").replace("objective", 'expressions: {thrust: "-min(u, -u)"}\nobjective'),
        2 * FASTEST,
        1e-10,
    ),
]


@cache
def polished(text):
    own = first(text)
    return own, polish(own.spec, own.solution)


@pytest.mark.parametrize(("text", "exact", "within"), share(EXACT, 2))
def test_kinks_and_switches_become_exact(text, exact, within, tmp_path):
    own, new = polished(text)
    assert "polished in 3 phases" in new.solution.notes[-1]
    assert new.solution.objective == pytest.approx(exact, abs=within)
    assert new.solution.objective_error.bar < own.solution.objective_error.bar
    path = tmp_path / "polished.h5"
    write(path, new.solution, new.spec.text, new.spec.model_dump_json(), "", new.spec.overrides)
    assert all(check.passed for check in verify(path, anew=False))


def test_the_reference_of_a_mesh_is_not_that_of_the_exact_problem():
    """That of block_move_min_work is of its 99 segments; one that agrees stays."""
    block, again = polished("block_move_min_work")
    assert block.spec.reference and again.spec.reference is None
    bryson, again = polished("bryson_denham")
    assert again.spec.reference == bryson.spec.reference


@pytest.mark.parametrize("treatment", ["{tanh: 0.1}", "{sqrt: [0.2, 0.05]}"])
def test_smooth_stand_ins_are_polished_as_they_are(treatment):
    meshes = "mesh: [{method: radau, segments: 10}, {method: radau, segments: 20}]\n" if "[" in treatment else ""
    text = MOVE.replace("final: 3", "final: {lower: 0.1, upper: 9, guess: 3}").replace("integral: ", "terminal: ")
    text = text.replace("WORK", "t[final]").replace("rate: u,", 'rate: "u - 0.5*abs(v - 0.2)",')
    own = first(text.replace("nonsmooth: slack", f"nonsmooth: {treatment}") + meshes)
    new = polish(own.spec, own.solution).solution
    assert "polished in 2 phases" in new.notes[-1]
    assert new.objective_error.bar < own.solution.objective_error.bar
    assert abs(new.objective - own.solution.objective) <= own.solution.objective_error.bar


def test_slack_variables_of_several_phases_are_told():
    phases = "phases: {one: {time: {final: 1}}, two: {}}\n"
    assert "slack variables" in why_not(load_yaml(MOVE.replace("WORK", "abs(u)") + phases))
    smooth = MOVE.replace("WORK", "abs(u)").replace("nonsmooth: slack", "nonsmooth: {tanh: 0.1}")
    assert why_not(load_yaml(smooth + phases)) == ""


@pytest.mark.parametrize(("weight", "wants"), [(5, True), (0.01, False)])
def test_a_kink_that_should_be_left_is_found(weight, wants):
    """min |u| + weight (v - 1)^2: with a small weight nothing is best; else it is worth something to push."""
    ends = "x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}"
    text = MOVE.replace("WORK", f"abs(u) + {weight}*(v - 1)**2").replace(ends, "v: {rate: u, initial: 0}")
    data = yaml.safe_load(with_slack(load_yaml(text)))
    data["controls"]["abs1_plus"] = data["controls"]["abs1_minus"] = {"lower": 0, "upper": 0}
    data["mesh"] = [{"method": "radau", "segments": 5}]
    forced = first(yaml.safe_dump(data)).solution
    fixed = {"abs1_plus": LOWER, "abs1_minus": LOWER}
    worth = worth_of_leaving(forced.trajectories[0], fixed, {"u": Range(-1, 1)}, 1)
    assert (worth > 0.1) == wants and (worth == 0) != wants


TEXTS = [
    "a - b - (c - 2)", "a/b/c", "a/(b*c)", "-(a + b)**2", "(-a)**2", "a**-b", "a**(b**c)", "2e-5*a - 3", "a - -b",
    "sin(a)*cos(b + c)**2", "min(a, b, c)", "max(-a, 0.25) + abs(b - c)", "hypot(a, b)", "pi*a", "sqrt(a)*exp(-b)",
]  # fmt: skip


@pytest.mark.parametrize("text", TEXTS)
def test_a_spelled_tree_means_the_same(text):
    values = dict(zip("abc", np.random.default_rng(0).uniform(0.5, 2, (3, 20)), strict=True))
    tree = parse(text)
    again = parse(spelled(tree.root))
    assert np.allclose(again(values, np), tree(values, np), rtol=1e-15, atol=0)
