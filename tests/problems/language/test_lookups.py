"""Lookups of tables at many points: in blocks, and once where segments share a knot, with the numbers of one by one."""

from itertools import combinations_with_replacement

import numpy as np
import pytest

from trajopt.problems.tables.table import fitted
from trajopt.transcription.program import lookups
from trajopt.transcription.program.lookups import Cells, CompiledLookup, Filled, Repeats, se

RANDOM = np.random.default_rng(3)


def table(n: int, points: int = 5):
    """A table of n arguments between 0 and 1."""
    grid = np.linspace(0, 1, points)
    names = "abc"[:n]
    values = RANDOM.normal(size=(points,) * n)
    every = dict.fromkeys(names, 0.0)
    return fitted(
        "f", {name: grid.tolist() for name in names}, values.tolist(), "cubic", dict.fromkeys(names, ""), every
    )


@pytest.mark.parametrize("backend", ["llvm", "lambda"])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_all_derivatives_of_blocks_are_those_of_the_table(n, backend, monkeypatch):
    monkeypatch.setattr(lookups, "READ", 7 * (4**n + n))  # seven points at once
    own, points = table(n), RANDOM.uniform(-0.2, 1.2, (50, n))
    found = Cells(own, backend)(points)
    axes = [one for order in range(3) for one in combinations_with_replacement(range(n), order)]
    assert found.shape == (50, len(axes))
    for column, one in zip(found.T, axes, strict=True):
        exact = own.derivative(points.T, [one.count(i) for i in range(n)])
        assert column == pytest.approx(exact, rel=1e-10, abs=1e-9)


def filled(own, numbers: int, steps: np.ndarray) -> tuple[np.ndarray, int]:
    """The arguments of a family whose lookups are at given points, and how many points the table was asked for.

    numbers: of lookups.
    steps: (S, numbers, n) the points.
    """
    size, _, n = steps.shape
    given = [[se.Symbol(f"x{k}_{i}") for i in range(n)] for k in range(numbers)]
    asked = [CompiledLookup(k, own, tuple(row)) for k, row in enumerate(given)]
    symbols = [symbol for row in given for symbol in row]
    code = lookups.lambdify([*symbols, se.Symbol("free")], symbols, "lambda")
    family = Filled(asked, [lambda arguments: code(arguments[:, : len(symbols) + 1])], len(symbols) + 1, "lambda")
    (_, [(_, _, _, cells, _)]) = family.steps[0]
    counted, count = cells.code, [0]

    def counting(rows, **options):
        count[0] += len(rows)
        return counted(rows, **options)

    cells.code = counting
    arguments = np.zeros((size, len(symbols) + 1 + numbers * cells.width))
    arguments[:, : len(symbols)] = steps.reshape(size, -1)
    family.fill(arguments)
    return arguments[:, len(symbols) + 1 :].reshape(size, numbers, -1), count[0]


def chained(size: int, n: int, middle: bool) -> np.ndarray:
    """Points at the start, perhaps the middle, and the end of segments."""
    knots, inside = RANDOM.uniform(0, 1, (size + 1, n)), RANDOM.uniform(0, 1, (size, n))
    parts = [knots[:-1], inside, knots[1:]] if middle else [knots[1:], knots[:-1]]
    return np.stack(parts, axis=1)


@pytest.mark.parametrize("middle", [True, False])
@pytest.mark.parametrize("n", [2, 3])
def test_a_knot_that_two_segments_share_is_looked_up_once(n, middle):
    own, size = table(n), lookups.MANY
    points = chained(size, n, middle)
    found, count = filled(own, points.shape[1], points)
    plain = Cells(own, "lambda")(points.reshape(-1, n)).reshape(found.shape)
    assert np.array_equal(found, plain)
    assert count == size * (points.shape[1] - 1) + 1


@pytest.mark.parametrize("kind", ["apart", "all alike", "one knot apart", "few"])
def test_other_points_are_looked_up_as_they_are(kind):
    own, size = table(3), lookups.MANY - (kind == "few")
    points = chained(size, 3, middle=True)
    if kind == "apart":
        points = RANDOM.uniform(0, 1, points.shape)
    elif kind == "all alike":
        points[:] = 0.3
    elif kind == "one knot apart":
        points[size // 2, 0] += 1e-3
    found, _ = filled(own, 3, points)
    assert np.array_equal(found, Cells(own, "lambda")(points.reshape(-1, 3)).reshape(found.shape))


def test_what_was_equal_once_is_compared_again():
    repeats, alike = Repeats(3, 2), np.full((lookups.MANY, 3, 2), 0.5)
    assert repeats.of(alike)
    points = chained(lookups.MANY, 2, middle=True)
    assert repeats.of(points) in ({0: 2}, {2: 0})
    assert not repeats.of(RANDOM.uniform(0, 1, points.shape))
