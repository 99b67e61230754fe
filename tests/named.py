"""Shipped problems by their names, and the methods of the table by their kinds."""

import os

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.problem import Problem
from trajopt.transcription.schemes.scheme import Scheme
from trajopt.transcription.schemes.table import METHODS, find

SLOW = {
    *("coulomb_friction", "free_flying_robot", "goddard", "goddard_speed_limit", "hang_glider", "min_time_climb"),
    *("quadrotor", "reorientation", "delta_iii"),
}
"""Shipped problems that take more than some 3 s: solved only where TRAJOPT_SLOW is set."""

SOLVED = [name for name in shipped() if name not in SLOW or os.environ.get("TRAJOPT_SLOW")]
"""Shipped problems that the tests solve."""

COLLOCATION = [name for name in METHODS if isinstance(find(name), Scheme)]
FAMILIES = [name for name, method in METHODS.items() if method.nodes]
"""Those that take a degree."""


def problem_named(name: str, *overrides: str) -> Problem:
    return build(load(shipped()[name], overrides))
