"""A control that the Hamiltonian does not depend on along a solution: it is stationary there by its symmetry only."""

import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.settings import Step
from trajopt.transcription.solve import solve
from trajopt.transcription.starts.worthless import worthless

SQUARE = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: a + y**2, initial: 0}, y: {rate: b, initial: 0}}
controls: {a: {lower: -1, upper: 1}, b: {lower: -1, upper: 1}}
objective: {maximize: {terminal: "x[final]"}}
"""
HILL = """
trajopt: 1
time: {initial: 0, final: 1.5}
states: {s: {rate: w, initial: 0}}
controls: {w: {lower: -2, upper: 2}}
objective: {minimize: {integral: -s**2}}
"""
PHASES = """
trajopt: 1
phases:
  first: {time: {initial: 0, final: 1}, states: {z: {initial: 0}, q: {initial: 0}}}
  second: {time: {final: 2}}
states: {z: {rate: 1 - cos(q)}, q: {rate: r}}
controls: {r: {lower: -1, upper: 1}}
links: [{from: first, to: second}]
objective: {maximize: {terminal: "second.z[final]"}}
"""
SLEW = """
trajopt: 1
time: {initial: 0, final: {lower: 0.1, upper: 20, guess: 5}}
states:
  p: {rate: v, initial: 0, final: 10}
  v: {rate: f + 0.8*(1 - cos(q)), initial: 0, final: 0}
  q: {rate: r, initial: 0, final: 0, lower: -1, upper: 1}
controls: {f: {lower: -1, upper: 1}, r: {lower: -1, upper: 1}}
objective: {minimize: {terminal: "t[final]"}}
"""


def solved(text: str, method: str = "radau", **options):
    spec = load_text(text, "x.yaml")
    return solve(build(spec), [Step(method, 12, 1e-8)], **options)


@pytest.mark.parametrize("method", ["radau", "hermite-simpson"])
@pytest.mark.parametrize(
    ("text", "names", "stationary", "optimum"),
    [
        (SQUARE, "b", "1", 4 / 3),  # y = t
        (HILL, "w", "0", -4.5),  # s = 2 t
        (PHASES, "r of phase first, r of phase second", "0", 2 - 0.9092974268256817),  # q = t
    ],
)
def test_another_start_is_tried(text, names, stationary, optimum, method):
    solution = solved(text, method)
    assert solution.solved and solution.objective == pytest.approx(optimum, abs=1e-4)
    (note,) = (own for own in solution.notes if "did nothing along the solution" in own)
    assert note.startswith(names) and "from another: controls above the middle of their bounds" in note
    told = float(note.partition("which led to ")[2].partition(";")[0])
    assert told == pytest.approx(float(stationary), abs=1e-3)


def test_a_slew_about_one_axis_is_not_the_shortest():
    """With q = 0 throughout it takes 2 sqrt(10) = 6.3246."""
    solution = solved(SLEW)
    assert solution.solved and solution.objective < 6.06
    assert any(own.startswith("r did nothing along the solution") for own in solution.notes)


@pytest.mark.parametrize("text", [SQUARE, HILL])
def test_from_a_guess_that_is_given_it_is_told(text):
    own = build(load_text(text, "x.yaml"))
    solution = solved(text, guess=[phase.guess for phase in own.phases])
    (note,) = solution.notes
    assert "does nothing along this solution (the Hamiltonian is the same whatever it is)" in note
    assert worthless(own, solution.trajectories, solution.objective) == [note[0]]


ALL = {
    "bang-bang": SQUARE.replace("y: {rate: b, initial: 0}", "y: {rate: b, initial: 0.1}"),
    "with a price": HILL.replace("-s**2", "-s**2 + w**2"),
    "a slack variable": """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {lower: -3, upper: 3}, p: {lower: 0, upper: 5}}
objective: {minimize: {integral: u**2}}
constraints: {path: [{expression: p - u, lower: 0}]}
""",
    "held": """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u + 2*p, initial: 0, final: 1}}
controls: {u: {lower: -3, upper: 3}, p: {lower: 0, upper: 0}}
objective: {minimize: {integral: u**2}}
""",
    "held where its square is flat, in one of two phases": """
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: u + p**2, initial: 0, final: 1}}
controls: {u: {lower: -3, upper: 3}, p: {lower: 0, upper: 1}}
phases: {rest: {time: {final: 1}, controls: {p: {upper: 0}}}, go: {controls: {p: {lower: 0.5}}}}
objective: {minimize: {integral: u**2 + p**4}}
""",
}


@pytest.mark.parametrize("what", ALL)
def test_other_controls_are_worth_something(what):
    solution = solved(ALL[what])
    told = [own for own in solution.notes if "nothing along" in own or "no effect" in own]
    assert solution.solved and not told
