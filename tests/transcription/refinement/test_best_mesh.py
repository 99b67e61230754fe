"""What refinement gives back is the most exact mesh; a finer goal never ends worse than the default."""

from dataclasses import replace

import pytest

from trajopt.transcription.again.kept import Candidates, Kept
from trajopt.transcription.continuation import solve_spec
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.loading import build_checked, load_file
from trajopt.transcription.refinement.basin import nearer
from trajopt.transcription.settings import Refine, Settings
from trajopt.transcription.solution.solution import with_error_bar


def solved(name, *overrides):
    spec = load_file(name, overrides)
    (problems,) = build_checked([spec])
    return solve_spec(spec, problems)


@pytest.mark.parametrize("name", ["clark_fishery", "jackson", "fuller", "double_integrator_min_time"])
def test_a_finer_goal_ends_no_worse_than_the_default(name):
    """The switches are closed in on before: without that clark_fishery had 505 segments and a bar of 9e-7."""
    usual, fine = solved(name), solved(name, "refine.objective=1e-10")
    assert fine.solved and fine.objective_error.bar < 0.5 * usual.objective_error.bar
    reference = load_file(name).reference.objective
    assert abs(fine.objective - reference) <= fine.objective_error.bar
    assert fine.meshes[-1].segments < 250


@pytest.mark.parametrize("name", ["catalyst_mixing", "flexible_spacecraft", "singular_double_integrator"])
def test_of_meshes_that_miss_the_goal_the_most_exact_is_given_back(name):
    found = solved(name, "refine.objective=2e-11")
    bars = [mesh.objective_error for mesh in (*found.meshes, *found.discarded) if mesh.status is Status.SOLVED]
    assert found.stopped and found.meshes[-1].objective_error == pytest.approx(min(bars), rel=1e-6)
    if found.discarded:
        assert f"the mesh of {found.meshes[-1].segments} segments is kept, not that of" in found.stopped
        assert found.discarded[-1].objective_error > min(bars)


@pytest.fixture(scope="module")
def mesh():
    return solved("shot_put")


def at(solution, objective, bar, error=1e-8):
    """The solution, as if it had this objective, error bar and error."""
    record = replace(solution.meshes[-1], relative_error=error, objective_error=bar)
    return with_error_bar(replace(solution, objective=objective, meshes=(record,)), bar)


@pytest.mark.parametrize(
    ("before", "after", "by_bar", "is_nearer"),
    [
        ((1, 1e-6), (1 + 1e-6, 2e-6), True, True),
        ((1, 2e-6), (1 + 1e-6, 1e-6), True, False),
        ((1, 1e-6), (1.1, 2e-6), True, False),  # one of the bars is wrong
        ((1, 1e-6, 1e-7), (1 + 1e-6, 2e-6), True, True),
        ((1, 1e-6, 1e-7), (1 + 1e-6, 2e-6), False, False),  # its dynamics are less exact
        ((1, 1e-6, 1e-9), (1 + 1e-6, 2e-6), False, True),
    ],
)
def test_a_mesh_is_nearer_by_a_smaller_bar_that_holds_the_other(mesh, before, after, by_bar, is_nearer):
    assert nearer(at(mesh, *before), at(mesh, *after), by_bar=by_bar) is is_nearer


def test_the_best_of_several_is_kept_and_told(mesh):
    bars = [4e-6, 1e-6, 2e-6, 3e-6]
    found = [(at(mesh, 1.0, bar), None) for bar in bars]
    candidates = Candidates(Settings(refine=Refine(objective=1e-9)))
    for known, own in enumerate(found, 1):
        candidates.add(Kept(own, (f"segment of mesh {known}",), known), refined=True)
    kept, why = candidates.instead_of(found[-1], True, "no more meshes", [])
    assert (kept.known, kept.unmet) == (2, ("segment of mesh 2",))
    assert why.startswith("no more meshes; the mesh of") and why.endswith("their error bars are 1.0e-06 and 3.0e-06")
    assert candidates.instead_of(found[-1], False, "", []) is None, "the last one is what was asked for"
    assert candidates.instead_of(found[1], True, "", []) is None


def test_meshes_before_refinement_are_of_other_problems(mesh):
    candidates = Candidates(Settings(refine=Refine(objective=1e-9)))
    found = [(at(mesh, 1.0, bar), None) for bar in (1e-6, 2e-6)]
    candidates.add(Kept(found[0], (), 1), refined=False)
    candidates.add(Kept(found[1], (), 2), refined=True)
    assert candidates.instead_of(found[1], True, "", []) is None
