"""The results whose pictures are looked at, solved once for all files of this room. Who changes one, changes a copy."""

import pytest

from .pictured import solved_in


@pytest.fixture(scope="session")
def solved(tmp_path_factory):
    """name -> a result file, each solved once."""
    return solved_in(tmp_path_factory.mktemp("results"))
