"""Arrays as sets: the same as NumPy's own functions."""

import numpy as np
import pytest

from trajopt.problems.sets import distinct, without


@pytest.mark.parametrize("values", [[], [2], [3, 1, 3, 2, 1], [[0.5, -0.0], [0.0, 0.5]], [1, 1, 1]])
def test_the_same_as_of_numpy(values):
    array = np.array(values)
    assert np.array_equal(distinct(array), np.unique(array))
    for others in ([], [1], [0.5, 3], np.arange(5)):
        assert np.array_equal(without(array, np.array(others)), np.setdiff1d(array, np.array(others)))
