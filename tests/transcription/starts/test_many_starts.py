"""Starts drawn within the bounds: which optima there are, and the best of them."""

import re

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.starts.drawn import NODES, drawn_starts, told_of_starts

# x**4 - x**2 + 0.2 x at the end has two local minima; the start leads to the lesser one.
WELLS = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, lower: -2, upper: 2, initial: 0.1}}
controls: {u: {lower: -3, upper: 3}}
objective: {minimize: {terminal: "x[final]**4 - x[final]**2 + 0.2*x[final]", integral: 1e-6*u**2}}
guess: {constants: {u: 0.6}}
mesh: [{method: trapezoid, segments: 5}]
"""


def solved(text: str, *overrides: str):
    spec = load_text(text, "x.yaml", overrides)
    return solve(build(spec), schedule_of(spec), settings_of(spec))


def test_the_better_of_two_optima_is_found_and_both_are_told():
    roots = np.roots([4, 0, -2, 0.2]).real
    lesser, better = (x**4 - x**2 + 0.2 * x for x in (roots.max(), roots.min()))
    assert solved(WELLS).objective == pytest.approx(lesser, abs=1e-4)
    many = solved(WELLS, "solver.starts=9")
    assert many.objective == pytest.approx(better, abs=1e-4)
    (note,) = many.notes
    counts = re.fullmatch(
        r"10 starts on the first mesh led to (\S+) \((\d+)\), (\S+) \((\d+)\); the best is kept", note
    )
    assert counts, note
    assert float(counts[1]) == pytest.approx(better, abs=1e-3) and float(counts[3]) == pytest.approx(lesser, abs=1e-3)
    assert int(counts[2]) + int(counts[4]) == 10
    assert len(many.meshes) == 1 and many.meshes[0].iterations > 10 * 3  # the work of all starts


def test_the_swing_up_has_a_better_optimum_than_the_paper_s():
    spec = load(shipped()["cartpole"], ["solver.starts=8", "solver.seed=1"])
    solution = solve(build(spec), schedule_of(spec), settings_of(spec))
    assert solution.objective == pytest.approx(57.9387, abs=1e-3) and "58.8054" in solution.notes[0]


def test_the_same_seed_gives_the_same_starts_within_the_bounds():
    text = WELLS.replace("final: 1}", "final: {lower: 0.5, upper: 3}}", 1) + "optimize: {p: {lower: -1, upper: 4}}\n"
    problem = build(load_text(text.replace("1e-6*u**2", "1e-6*u**2 + p**2"), "x.yaml"))
    one, same, other = ([g for (g,) in drawn_starts(problem, 5, seed)] for seed in (3, 3, 4))
    for first, second in zip(one, same, strict=True):
        assert first.parameters == second.parameters and first.final_time == second.final_time
        assert all((first.values[name] == second.values[name]).all() for name in first.values)
    assert one[0].final_time != other[0].final_time
    assert len({g.final_time for g in one}) == 5 and all(0.5 <= g.final_time <= 3 for g in one)
    assert all(-1 <= g.parameters["p"] <= 4 and np.abs(g.values["u"]).max() <= 3 for g in one)
    kinks = np.abs(np.diff(one[0].values["u"], 2)) > 1e-9
    assert kinks.sum() <= 2 * (NODES - 2)  # linear between the nodes
    slope = np.gradient(one[0].values["x"], one[0].s * one[0].final_time)
    assert slope[5:95] == pytest.approx(one[0].values["u"][5:95], abs=0.2)  # simulated under the control


def test_many_optima_are_told_in_few_words():
    words = told_of_starts([*map(float, range(10)), 3.00001, None, None], sense=-1)
    assert words == (
        "13 starts on the first mesh led to 9 (1), 8 (1), 7 (1), 6 (1), 5 (1), 4 (1), 4 more optima, not solved (2); "
        "the best is kept"
    )
