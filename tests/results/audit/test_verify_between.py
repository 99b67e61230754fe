"""Bounds between the points: a control that might as well be held within them is no failure, others are."""

import pytest
from command_line import solved_once, trajopt

from trajopt.results.verify import verify

COARSE = "mesh=[{method: radau, segments: 2}]"
COPY = """\
trajopt: 1
time: {initial: 0, final: 3.5}
states: {x: {rate: v, initial: 0, final: 0}, v: {rate: u, initial: 1, final: 0}}
controls: {u: {}, w: {lower: -1, upper: 1}}
constraints: {path: [{expression: u - w, equals: 0}]}
objective: {minimize: {integral: x**2}}
mesh: [{method: radau, segments: 2}]
"""
"""Fuller's problem, whose bounded control has to be one without bounds: held within its bounds it breaks that."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("between")


def check_of(path, name):
    (found,) = [own for own in verify(path) if own.name == f"{name} between the points"]
    return found


def test_a_control_that_might_be_held_within_its_bounds_passes(folder):
    """The chattering end of Fuller's problem: u is beyond its bound by 12 % of 1 + |bound|, for a moment."""
    check = check_of(solved_once(folder / "fuller.h5", "fuller"), "bounds of u")
    assert check.passed and "held within its bounds it would move v by that" in check.where
    assert trajopt("verify", folder / "fuller.h5").exit_code == 0


def test_a_control_whose_excess_moves_a_state_fails(folder):
    check = check_of(solved_once(folder / "coarse.h5", "fuller", "--set", COARSE), "bounds of u")
    assert not check.passed and "held within" not in check.where


def test_a_control_that_a_path_constraint_needs_beyond_its_bounds_fails(folder):
    (folder / "copy.yaml").write_text(COPY)
    check = check_of(solved_once(folder / "copy.h5", folder / "copy.yaml"), "bounds of w")
    assert not check.passed and "held within" not in check.where
