"""An earlier result as the guess of a new solve, also of another problem."""

import numpy as np
import pytest
from stored import save, solved

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load
from trajopt.results.file.guess import guess_from, lacking
from trajopt.transcription.settings import steps
from trajopt.transcription.solve import solve


def test_a_result_starts_the_next_solve(tmp_path):
    spec, solution = solved("cartpole")
    guess = guess_from(save(tmp_path / "a.h5", "cartpole"), solution.problem)
    again = solve(solution.problem, steps(spec.mesh), guess=guess)
    assert again.solved and again.meshes[0].iterations < solution.meshes[0].iterations
    with pytest.raises(SpecError, match="none of the states"):
        guess_from(save(tmp_path / "b.h5"), solution.problem)


def test_what_the_result_does_not_have_is_told(tmp_path):
    path = save(tmp_path / "a.h5")
    shot, richer = solved("shot_put")[0], build(load(shipped()["bryson_denham"]))
    assert not lacking(path, build(shot))
    (told,) = lacking(path, richer)
    assert str(told) == f"{path}: it does not have v (1 to -1), u (0); these start from the guess of the problem file"
    (guess,) = guess_from(path, richer)
    assert np.ptp(guess.values["v"]) == 2
