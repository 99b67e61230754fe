"""The walking problem of the paper's section 7, built without a problem file."""

import numpy as np

from trajopt.problems.models import find_model
from trajopt.problems.problem import Guess, Phase, Problem
from trajopt.problems.quantities import Constraint, Range, State, Variable
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve

HS = "hermite-simpson"
LINKS = range(1, 6)
TABLE_4 = {
    "m": (3.2, 6.8, 20.0, 6.8, 3.2),
    "I": (0.93, 1.08, 2.22, 1.08, 0.93),
    "l": (0.4, 0.4, 0.625, 0.4, 0.4),
    "d": (0.128, 0.163, 0.2, 0.163, 0.128),
}
LOPSIDED = {  # no two links alike: nothing may be right by symmetry
    "m": (3.2, 6.8, 20.0, 5.1, 2.3),
    "I": (0.93, 1.08, 2.22, 0.71, 0.55),
    "l": (0.41, 0.37, 0.625, 0.44, 0.39),
    "d": (0.128, 0.163, 0.2, 0.21, 0.19),
}
G, STEP, T = 9.81, 0.5, 0.7
Q0 = np.array([-0.3, 0.7, 0.0, -0.5, -0.6])  # (7.8)
SUPPLEMENT = {"d3": 0.425}
BOUNDS = {"q": Range(-np.pi / 2, np.pi / 2), "dq": Range(-10, 10), "ddq": Range(), "u": Range(-100, 100)}
KNEES = (
    Constraint("stance_knee", lambda v, m: v["q1"] - v["q2"], Range(upper=0)),
    Constraint("swing_knee", lambda v, m: v["q5"] - v["q4"], Range(upper=0)),
)


def parameters(table=TABLE_4, **changes) -> dict[str, float]:
    rows = {f"{symbol}{i}": value for symbol, row in table.items() for i, value in zip(LINKS, row, strict=True)}
    return {**rows, "g": G, "step_length": STEP, **changes}


def biped(path=(), table=TABLE_4, **changes) -> Problem:
    """The walking problem of the paper's section 7, for Table 4 with some parameters changed."""
    model = find_model("five_link_biped")
    equations = model.build(parameters(table, **changes))
    ranges = {name: BOUNDS[name[:-1]] for name in (*model.states, *model.controls, *model.algebraic)}
    ranges["u1"] = Range(0, 0)  # the ankle has no motor
    keyframes = np.array([Q0, Q0[::-1]])  # (7.8), (7.9)
    guess = dict.fromkeys((*model.controls, *model.algebraic), np.zeros(2))  # (7.11)
    guess |= {f"q{i}": keyframes[:, i - 1] for i in LINKS}
    guess |= {f"dq{i}": np.full(2, (keyframes[1] - keyframes[0])[i - 1] / T) for i in LINKS}  # (7.10)
    phase = Phase(
        name="main",
        initial_time=Range(0, 0),
        final_time=Range(T, T),
        states=tuple(
            State(name, bounds=ranges[name], rate=rate, initial=ranges[name], final=ranges[name])
            for name, rate in equations.rates.items()
        ),
        controls=tuple(Variable(name, bounds=ranges[name]) for name in model.controls),
        guess=Guess(0, T, np.array([0.0, 1.0]), guess),
        algebraic=tuple(map(Variable, model.algebraic)),
        residuals=tuple(Constraint(name, f, Range(0, 0)) for name, f in equations.residuals.items()),
        path=tuple(path),
        boundary=tuple(Constraint(name, f, bounds) for name, (f, bounds) in equations.boundary.items()),
        lagrange=lambda v, m: sum(v[f"u{i}"] ** 2 for i in LINKS),  # (7.1)
    )
    return Problem("biped", 1, (phase,))


def run(problem: Problem, *schedule: tuple):
    solution = solve(problem, [Step(*entry) for entry in schedule])
    assert solution.solved, solution.status
    return solution
