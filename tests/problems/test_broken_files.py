"""All mistakes of a file at once, in order; each of `broken.CASES` by itself is in test_cli."""

import broken
import pytest

from trajopt.problems.chains.robots import ROBOTS
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load


def test_the_good_file_is_good(tmp_path):
    path = tmp_path / "good.yaml"
    path.write_text(broken.GOOD)
    assert not load(path, methods=broken.METHODS).warnings


def test_there_are_enough_cases():
    assert len({case.name for case in broken.CASES}) == len(broken.CASES) >= 60


def test_all_mistakes_at_once_in_the_order_of_lines(tmp_path):
    path = tmp_path / "bad.yaml"
    path.write_text(broken.GOOD.replace("u*v", "u*w").replace("rate: v,", "rate: vv,").replace("upper: 3", "upper: q"))
    with pytest.raises(SpecError) as error:
        load(path, ["controls.u.upper=z"], broken.METHODS)
    places = [mistake.where.removeprefix(f"{path}:") for mistake in error.value.mistakes]
    assert places == [
        "9: expressions.power",
        "12: states.x.rate",
        "21: constraints.path.0.upper",
        "--set controls.u.upper",
    ]


def test_what_a_model_needs_is_told_in_its_own_order(tmp_path):
    path = tmp_path / "bare.yaml"
    path.write_text(
        "{trajopt: 1, model: five_link_biped, time: {initial: 0, final: 1}, objective: {minimize: {integral: u1**2}}}"
    )
    with pytest.raises(SpecError) as error:
        load(path, methods=broken.METHODS)
    needed = [mistake.what.split(",")[0].split()[-1] for mistake in error.value.mistakes]
    assert needed == list(ROBOTS["five_link_biped"].parameters)[: len(needed)] and len(needed) > 10
