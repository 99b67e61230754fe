"""A finer mesh that keeps the bounds between its points is not called worse than a coarse one that exceeds them."""

from dataclasses import replace

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.transcription.loading import load_yaml
from trajopt.transcription.refinement.basin import left_basin
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

DESCENT = """\
trajopt: 1
name: a descent that may not pass below the ground, least fuel
time: {initial: 0, final: {lower: 20, upper: 150, guess: 75}}
states:
  z: {rate: vz, initial: 1500, final: 0, lower: 0}
  r: {rate: vr, initial: RANGE, final: 0}
  vz: {rate: Tz/m - 3.7114, initial: -75, final: 0}
  vr: {rate: Tr/m, initial: SPEED, final: 0}
  m: {rate: -5.086e-4*sqrt(Tz**2 + Tr**2), initial: 1905, lower: 1505}
controls: {Tz: {}, Tr: {}}
constraints: {path: [{name: thrust, expression: sqrt(Tz**2 + Tr**2), lower: 4972, upper: 13259}]}
objective: {maximize: {terminal: "m[final]"}}
guess: {constants: {Tz: 8000, Tr: 10}}
"""
OPTIMA = {(2500, 80): 1528.9455479, (2600, 60): 1553.628362}
"""The mass at the end by refinement to a bar of 5e-9, relative, from another first mesh."""


def solved(start, distance, speed):
    spec = load_yaml(start.replace("RANGE", str(distance)).replace("SPEED", str(speed)))
    return solve(build(spec), schedule_of(spec), settings_of(spec))


@pytest.fixture(scope="module", params=OPTIMA)
def descent(request):
    return solved(DESCENT, *request.param), OPTIMA[request.param]


def test_the_coarse_mesh_that_cuts_through_the_ground_is_refined(descent):
    solution, optimum = descent
    assert not solution.inaccurate and not solution.stopped and not solution.unmet
    assert abs(solution.objective - optimum) <= solution.objective_error.bar <= 1e-6 * (1 + optimum)


def test_what_is_exceeded_between_the_points_widens_the_bar_of_the_mesh_before(descent):
    fine = descent[0]
    bar = fine.objective_error.bar
    (error,) = fine.errors
    exceeded = {"bounds of z": np.full(len(error.relative), 0.5)}
    coarse = replace(fine, errors=(replace(error, excess=exceeded),))
    worse = replace(fine, objective=fine.objective - 15 * bar)  # of a maximum
    assert left_basin(fine, worse)
    assert not left_basin(coarse, worse)
    assert left_basin(coarse, replace(worse, errors=coarse.errors))  # the finer one is no better
    assert left_basin(coarse, replace(fine, objective=fine.objective - 50 * bar))


def test_a_loss_within_the_accuracy_asked_for_is_none(descent):
    fine = descent[0]
    loss = 15 * fine.objective_error.bar
    worse = replace(fine, objective=fine.objective - loss)
    assert left_basin(fine, worse, accuracy=0.5 * loss / fine.objective)
    assert not left_basin(fine, worse, accuracy=2 * loss / fine.objective)
