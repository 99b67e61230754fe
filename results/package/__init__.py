"""trajopt: trajectory optimization from a problem file; docs/python.md has examples.

    import trajopt
    problem = trajopt.load("cartpole", {"parameters.u_max": 12})
    solution = trajopt.solve(problem)
    solution["q1"](0.5)

The names are imported when they are first used, so that the command line starts as fast as without them.
"""

from importlib import import_module
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from trajopt.problems.errors import FileError, Mistake, SpecError, TrajoptError
    from trajopt.results.python.problem import LoadedProblem, load
    from trajopt.results.python.solution import PhaseView, SolutionView
    from trajopt.results.python.solving import read, solve
    from trajopt.results.python.time_function import TimeFunction

_HOMES = {
    "load": "trajopt.results.python.problem",
    "solve": "trajopt.results.python.solving",
    "read": "trajopt.results.python.solving",
    "LoadedProblem": "trajopt.results.python.problem",
    "SolutionView": "trajopt.results.python.solution",
    "PhaseView": "trajopt.results.python.solution",
    "TimeFunction": "trajopt.results.python.time_function",
    "Mistake": "trajopt.problems.errors",
    "TrajoptError": "trajopt.problems.errors",
    "SpecError": "trajopt.problems.errors",
    "FileError": "trajopt.problems.errors",
}
"""Name -> the module that has it."""

__all__ = [
    "FileError",
    "LoadedProblem",
    "Mistake",
    "PhaseView",
    "SolutionView",
    "SpecError",
    "TimeFunction",
    "TrajoptError",
    "load",
    "read",
    "solve",
]


def __getattr__(name: str) -> object:
    if name not in _HOMES:
        raise AttributeError(f"module 'trajopt' has no attribute '{name}'; it has {', '.join(__all__)}")
    value: object = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return __all__
