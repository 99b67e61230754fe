"""The shooting methods, and shipped problems solved by them."""

from functools import cache

import pytest
from named import problem_named

from trajopt.transcription.schemes.runge_kutta import TABLES
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

SCHEMES = [(table.name, control) for table in TABLES for control in table.controls]
SCHEME = pytest.mark.parametrize(("method", "control"), SCHEMES)


@cache
def solved(name: str, method: str, segments: int, substeps: int, control: str | None = None):
    solution = solve(problem_named(name), [Step(method, segments, 1e-9, substeps=substeps, control=control)])
    assert solution.solved, solution.status
    return solution
