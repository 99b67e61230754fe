"""A solved mesh is never replaced by one that ended at IPOPT's acceptable point."""

from dataclasses import replace

import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.attempts.attempt import better
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.loading import load_file
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

EASILY_ACCEPTABLE = ["solver.acceptable_iter=1", "solver.acceptable_tol=1e-2"]
"""IPOPT ends at the first point that meets 1e-2, unless it meets the mesh's own tolerance at once."""

STEER = """\
trajopt: 1
time: {initial: 0, final: 3}
states:
  x: {rate: sin(y), initial: 0, final: 1}
  y: {rate: u - 0.3*y*x, initial: 0, final: 0}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh:
  - {segments: 4, method: hermite-simpson, tolerance: 1e-2}
  - {segments: 12, method: hermite-simpson, tolerance: 1e-9}
"""


def solved(spec):
    return solve(build(spec), steps(spec.mesh), settings_of(spec))


@pytest.fixture(scope="module")
def steered():
    return solved(load_text(STEER, "steer.yaml", EASILY_ACCEPTABLE))


def test_of_a_schedule_the_mesh_that_was_solved_is_kept(steered):
    assert steered.status is Status.SOLVED
    assert [mesh.segments for mesh in steered.meshes] == [4]
    assert [(mesh.segments, mesh.status) for mesh in steered.discarded] == [(12, Status.ACCEPTABLE)]
    assert steered.stopped == f"the next mesh, of 12 segments, {Status.ACCEPTABLE.message}"
    assert steered.inaccurate


def test_of_refinement_the_mesh_that_was_solved_is_kept_and_its_segments_told():
    loose = ["refine.tolerance=1e-8", "mesh.0.tolerance=1e-2"]
    found = solved(load_file("brachistochrone", [*loose, *EASILY_ACCEPTABLE]))
    assert found.status is Status.SOLVED and found.objective_error.applies
    assert {mesh.status for mesh in found.discarded} == {Status.ACCEPTABLE}
    assert [mesh.status for mesh in found.meshes] == [Status.SOLVED]
    assert found.unmet and found.inaccurate and Status.ACCEPTABLE.message in found.stopped


@pytest.fixture(scope="module")
def accepted():
    return solved(load_text(STEER, "steer.yaml", [*EASILY_ACCEPTABLE, "solver.accept=acceptable"]))


def test_where_acceptable_is_accepted_the_last_mesh_stands(accepted):
    assert accepted.solved and accepted.status is Status.ACCEPTABLE and not accepted.discarded
    assert [mesh.segments for mesh in accepted.meshes] == [4, 12]


def test_without_a_solved_mesh_the_acceptable_one_is_what_there_is():
    only = STEER.replace("  - {segments: 4, method: hermite-simpson, tolerance: 1e-2}\n", "")
    found = solved(load_text(only, "steer.yaml", EASILY_ACCEPTABLE))
    assert found.status is Status.ACCEPTABLE and not found.solved and not found.stopped


def test_no_other_start_is_better_by_an_acceptable_point(steered, accepted):
    assert accepted.objective > steered.objective + 1e-6
    assert not better(accepted, steered, -1)  # for a maximum it would be
    assert better(replace(accepted, status=Status.SOLVED), steered, -1)


@pytest.mark.parametrize(
    ("new", "old", "may"),
    [
        (Status.ACCEPTABLE, Status.SOLVED, False),
        (Status.ACCEPTABLE, Status.FEASIBLE, False),
        (Status.ACCEPTABLE, Status.ACCEPTABLE, True),
        (Status.ACCEPTABLE, Status.INFEASIBLE, True),
        (Status.SOLVED, Status.ACCEPTABLE, True),
        (Status.STALLED, Status.INFEASIBLE, False),
    ],
)
def test_which_status_may_stand_in_place_of_which(new, old, may):
    assert new.may_replace(old) is may
