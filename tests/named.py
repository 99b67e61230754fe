"""Shipped problems by their names."""

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.problems.problem import Problem


def problem_named(name: str, *overrides: str) -> Problem:
    return build(load(shipped()[name], overrides))
