"""A mesh as data: points, knots and weights."""

import numpy as np
import pytest

from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import HERMITE_SIMPSON, METHODS, TRAPEZOID, find


@pytest.mark.parametrize("method", METHODS)
def test_points_and_weights_of_an_uneven_mesh(method):
    mesh = Mesh.of(find(method), [1, 2, 5])
    assert mesh.edges == pytest.approx([0, 1 / 8, 3 / 8, 1])
    assert mesh.fractions[mesh.knots] == pytest.approx(mesh.edges)
    assert mesh.fractions[0] == 0
    assert mesh.fractions[-1] == 1
    assert (np.diff(mesh.fractions) > 0).all()
    assert mesh.weights.sum() == pytest.approx(1, abs=1e-15)
    if "euler" not in method:
        assert mesh.weights @ mesh.fractions == pytest.approx(1 / 2, abs=1e-15)


def test_neighbouring_segments_share_their_knot():
    mesh = Mesh.of(HERMITE_SIMPSON, 3)
    assert mesh.groups[0].nodes.tolist() == [[0, 1, 2], [2, 3, 4], [4, 5, 6]]
    assert mesh.weights * 18 == pytest.approx([1, 4, 2, 4, 2, 4, 1])  # (1 + 4 + 1) / 6 over 3 segments


@pytest.mark.parametrize("widths", [[], [1, 0], [1, -1], [[1, 2]]])
def test_impossible_widths_are_refused(widths):
    with pytest.raises(ValueError, match="positive"):
        Mesh.of(TRAPEZOID, widths)
