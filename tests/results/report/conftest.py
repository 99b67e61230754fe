"""The results whose pages are looked at, made once for all files of this room. Who changes one, changes a copy."""

import pytest

from .pages import solved_in, swept_in


@pytest.fixture(scope="session")
def place(tmp_path_factory):
    return tmp_path_factory.mktemp("results")


@pytest.fixture(scope="session")
def solved(place):
    """name -> a result file, each solved once."""
    return solved_in(place)


@pytest.fixture(scope="session")
def swept(place):
    """The folder of a sweep."""
    return swept_in(place)
