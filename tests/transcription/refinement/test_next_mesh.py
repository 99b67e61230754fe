"""The next mesh, from the errors of the one before: which segments are split, get points, or are merged."""

from dataclasses import replace

import numpy as np
import pytest
from exact import growth

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.transcription.refinement.refine import MARGIN, MERGE_MARGIN, refine
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Step, settings_of, steps
from trajopt.transcription.solve import solve


def test_segments_are_split_in_proportion_to_their_error():
    solution = solve(growth(), [Step("trapezoid", [3, 1, 1], 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    errors, error = error.relative, replace(error, worth=np.zeros(3))
    refinement = refine(trajectory, error, tolerance=float(errors[1:].max()) / MARGIN * 1.01)
    assert refinement.mesh.segments > 3
    assert refinement.mesh.widths[-2:] == pytest.approx(trajectory.mesh.widths[1:])  # the good ones are left alone
    assert refinement.mesh.widths[:-2].sum() == pytest.approx(trajectory.mesh.widths[0])


def test_neighbours_are_divided_together_where_the_method_has_one_degree():
    """Ten equal segments that each need a little more than one part become a few more segments, not twenty."""
    solution = solve(growth(), [Step("hermite-simpson", 10, 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    tolerance = float(error.relative.min())
    refinement = refine(trajectory, error, tolerance)
    assert 10 < refinement.mesh.segments < 20
    again = solve(growth(), [Step("hermite-simpson", refinement.mesh.widths.tolist(), 1e-11)])
    errors = again.errors[0].relative
    assert errors.max() < tolerance
    assert errors.max() < 2 * errors.min()  # the density of segments follows the error


def test_what_a_switch_needs_is_not_moved_by_its_neighbours():
    """Where the degree is free, a segment that is split keeps its ends as knots."""
    solution = solve(build_all(load(shipped()["hyper_sensitive"]))[0], [Step("radau", 30, 1e-9, 4)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    refined = refine(trajectory, error, 1e-6, merge=False).mesh
    assert refined.segments > 30
    assert np.isin(trajectory.mesh.edges.round(12), refined.edges.round(12)).all()


def test_neighbours_are_merged_only_far_below_the_tolerance():
    solution = solve(growth(), [Step("hermite-simpson", [20, *[1] * 10], 1e-11)])
    (trajectory,), (error,) = solution.trajectories, solution.errors
    errors = error.relative
    tolerance = float(errors[0]) / 2
    assert errors[1:].max() < MERGE_MARGIN * tolerance
    merged = refine(trajectory, error, tolerance)
    kept = refine(trajectory, error, tolerance, merge=False)
    assert merged.mesh.segments == kept.mesh.segments - 5
    assert merged.mesh.widths.sum() == pytest.approx(1)


def test_smooth_segments_get_points_and_rough_ones_are_split():
    smooth = solve(growth(), [Step("radau", 2, 1e-11, 4)])
    (trajectory,), (error,) = smooth.trajectories, smooth.errors
    raised = refine(trajectory, error, 1e-9).mesh
    assert raised.segments == 2
    assert min(scheme.degree for scheme in raised.schemes) > 4
    spec = load(shipped()["hyper_sensitive"], ["refine.max_meshes=1"])
    rough = solve(build_all(spec), steps(spec.mesh), settings_of(spec))
    assert rough.meshes[1].mesh.widths.min() < rough.meshes[0].mesh.widths.min()


def test_meshes_are_pure_data():
    mesh = Mesh.of(find("radau", 3), 4)
    assert mesh.segments == 4
    with pytest.raises(AttributeError):
        mesh.widths = None
