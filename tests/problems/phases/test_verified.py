"""Results of phases, read back and verified."""

import h5py
import numpy as np

from trajopt.problems.build import build
from trajopt.results.file.reload import reload
from trajopt.results.verify import verify
from trajopt.transcription.settings import schedule_of
from trajopt.transcription.solve import solve

from .phased import MOVE, loaded, written


def test_a_result_of_phases_is_read_back_and_verified(tmp_path):
    spec = loaded(MOVE, "phases.first.mesh=[{method: radau, segments: 3}]")
    solution = solve(build(spec), schedule_of(spec))
    path = written(solution, spec, tmp_path)
    again = reload(path)
    assert [mesh.schemes[0].name for mesh in again.records[-1].grids] == ["radau", "hermite-simpson"]
    for ours, theirs in zip(again.trajectories, solution.trajectories, strict=True):
        np.testing.assert_allclose(ours.x, theirs.x, atol=1e-12)
        np.testing.assert_allclose(ours.costate, theirs.costate, atol=1e-9)
    checks = {check.name: check for check in verify(path)}
    assert all(check.passed for check in checks.values())
    assert checks["links between phases, relative"].where and "H goes on from first to second, relative" in checks
    assert "second: simulated x, relative to its range" in checks


FREE = "{lower: 0.1, upper: 0.9, guess: 0.3}"


TIGHT = "{lower: 0.2999, upper: 0.3001}"


def at_a_time(bounds: str):
    """The move through x = 0.6 at a time within bounds."""
    text = MOVE.replace(
        "second: {time: {initial: {lower: 0.2, upper: 0.8}}}", f"second: {{time: {{initial: {bounds}}}}}"
    )
    text = text.replace("first: {}", f"first: {{time: {{final: {bounds}}}, states: {{x: {{final: 0.6}}}}}}")
    return loaded(text)


def test_verify_sees_a_passage_at_another_time_than_the_best(tmp_path):
    """The solution of a passage that was held at 0.3, told to be one of a free time."""
    tight, free = at_a_time(TIGHT), at_a_time(FREE)
    held = solve(build(tight), schedule_of(tight))
    assert held.objective > solve(build(free), schedule_of(free)).objective + 0.1
    failed = [check.name for check in verify(written(held, free, tmp_path)) if not check.passed]
    assert "H goes on from first to second, relative" in failed
    assert not [c for c in verify(written(held, tight, tmp_path)) if c.name.startswith("H goes on")]


def test_verify_sees_a_broken_link(tmp_path):
    spec = at_a_time(FREE)
    path = written(solve(build(spec), schedule_of(spec)), spec, tmp_path)
    start_of_v = int(reload(path).transcription.phases[1].x[1, 0])
    with h5py.File(path, "r+") as file:
        file["solver/z"][start_of_v] += 0.5
    (broken,) = [check for check in verify(path) if check.name.startswith("links")]
    assert not broken.passed and broken.where == "v from first to second"


BRANCHES = """
trajopt: 1
states: {x: {rate: v}, v: {rate: u}}
controls: {u: {}}
phases:
  out: {time: {initial: 0, final: WHEN}, states: {x: {initial: 0, final: 1}, v: {initial: 0}}}
  probe: {time: {initial: WHEN, final: 3}, states: {x: {final: 2}, v: {final: 0}}}
  spare: {time: {initial: WHEN, final: 5}, states: {x: {final: 1.5}}}
  home: {time: {initial: WHEN, final: 4}, states: {x: {final: 0}, v: {final: 0}}}
links: [{from: out, to: probe}, {from: out, to: spare}, {from: out, to: home}]
objective: {minimize: {integral: u**2}}
mesh: [{method: radau, segments: 4}]
"""


def test_where_phases_branch_the_hamiltonians_of_all_that_begin_are_added(tmp_path):
    free = loaded(BRANCHES.replace("WHEN", "{lower: 0.1, upper: 2.9, guess: 1}"))
    solution = solve(build(free), schedule_of(free))
    name = "H goes on from out to probe and spare and home, relative"
    checks = {check.name: check for check in verify(written(solution, free, tmp_path))}
    assert checks[name].value < 1e-6 and all(check.passed for check in checks.values())
    held = loaded(BRANCHES.replace("WHEN", "{lower: 0.6999, upper: 0.7001}"))
    early = solve(build(held), schedule_of(held))
    assert early.objective > solution.objective + 0.1
    assert name in [check.name for check in verify(written(early, free, tmp_path)) if not check.passed]
