"""A point that the engine calls optimal is not called solved where nothing is known of its error, or too little."""

import pytest

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve


def solved(text: str):
    spec = load_text(text, "a.yaml")
    return solve(build(spec), steps(spec.mesh), settings_of(spec))


BEAD = """
trajopt: 1
name: bead on a parabola
time: {initial: 0, final: 1}
states:
  a: {rate: b, initial: 0, final: 1}
  b: {initial: 0, final: 0}
  c: {rate: d}
  d: {}
algebraic: {n: {}}
controls: {f: {lower: -50, upper: 50}}
residuals: ["b[rate] - f + 2*a*n", "d[rate] + 9.81 - n", "c - a**2"]
objective: {minimize: {integral: f**2}}
mesh: [{method: METHOD, segments: 10}]
"""
ROD = """
trajopt: 1
name: rod
time: {initial: 0, final: 1.5}
states: {X: {rate: VX, initial: 5, final: 4}, Y: {rate: VY, initial: 0}, VX: {initial: 0}, VY: {initial: 0}}
algebraic: {T: {}}
controls: {F: {lower: -90, upper: 90}}
residuals: ["2*VX[rate] - T*X - F", "2*VY[rate] + 19.62 - T*Y", "X**2 + Y**2 - 25"]
objective: {minimize: {integral: F**2}}
mesh: [{method: METHOD, segments: 10}]
"""


@pytest.mark.parametrize("method", ["radau", "gauss"])
@pytest.mark.parametrize("text", [BEAD, ROD], ids=["bead", "rod"])
def test_an_index_above_one_on_a_mesh_of_the_file(text, method):
    """The bead, pushed by nobody, was "solved": an impulse of n in the first segment moves it."""
    solution = solved(text.replace("METHOD", method))
    assert "the residuals do not determine the rates (index above 1)" in solution.inaccurate


POLES = {
    "the objective divides by x": """
states: {x: {rate: u, initial: -1, final: 1}}
controls: {u: {lower: -3, upper: 3}}
objective: {minimize: {integral: u**2 + 0.01/x}}
""",
    "the rate of V divides by -0.5 + H": """
states: {H: {rate: V, initial: 2, final: -1}, V: {rate: A/(H - 0.5), initial: 0}}
controls: {A: {lower: -30, upper: 30}}
objective: {minimize: {integral: A**2}}
""",
    "the objective divides by 1.0 - r": """
states: {r: {rate: w, initial: 0, final: 2.3}}
controls: {w: {}}
objective: {minimize: {integral: "w**2 + 0.1/(1 - r)"}}
""",
}


@pytest.mark.parametrize("told", POLES)
def test_a_pole_that_is_crossed_is_named(told):
    solution = solved(f"trajopt: 1\nname: pole\ntime: {{initial: 0, final: 2}}\n{POLES[told]}")
    assert not solution.solved or solution.inaccurate
    words = [*solution.notes, solution.trouble]
    assert any(word.startswith(told) and "a bound that keeps" in word for word in words), words


NO_POLES = {
    "a sine": "{x: {rate: v, initial: -2, final: 2.5}, v: {rate: u - sin(5*x)/x, initial: 0, final: 0}}",
    "a growth": "{x: {rate: v, initial: -2, final: 2.5}, v: {rate: u - 9*(exp(3*x) - 1)/x, initial: 0, final: 0}}",
    "a square": "{x: {rate: v, initial: -3, final: 3}, v: {rate: u - 4*(1 - cos(6*x))/x**2, initial: 0, final: 0}}",
}


@pytest.mark.parametrize("told", NO_POLES)
def test_a_quotient_with_a_limit_has_no_pole(told):
    """On a mesh that is too coarse: sin(x)/x is as smooth as any where x changes its sign."""
    text = f"trajopt: 1\nname: limit\ntime: {{initial: 0, final: 2}}\nstates: {NO_POLES[told]}\n"
    solution = solved(
        f"{text}controls: {{u: {{}}}}\nobjective: {{minimize: {{integral: u**2}}}}\n"
        "mesh: [{method: trapezoid, segments: 7}]\n"
    )
    assert solution.solved and solution.inaccurate and solution.objective_error.applies
    assert not any("divides" in note for note in solution.notes)


COARSE = {
    "a disc is cut": """
states: {x: {rate: u, initial: 0, final: 1}, y: {rate: w, initial: 0, final: 1}}
controls: {u: {}, w: {}}
objective: {minimize: {integral: u**2 + w**2}}
constraints: {path: [{name: disc, expression: (x - 0.5)**2 + (y - 0.48)**2, lower: 0.04}]}
mesh: [{method: trapezoid, segments: 6}]
""",
    "a control between two values is best": """
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: -1, upper: 1}}
objective: {minimize: {integral: x**2 + (u**2 - 1)**2}}
""",
    "a cap of an algebraic variable, which the control moves a little, is left at the end": """
states: {x: {rate: u, initial: 0}}
algebraic: {z: {}}
residuals: [z - x**2 - 1e-6*u]
controls: {u: {lower: -10, upper: 10}}
objective: {maximize: {terminal: "x[final]", integral: -0.01*u**2}}
constraints: {path: [{name: cap, expression: z, upper: 4}]}
mesh: [{method: gauss, segments: 5, degree: 3}]
""",
}


@pytest.mark.parametrize("what", COARSE)
def test_a_wide_error_bar_is_no_solution(what):
    solution = solved(f"trajopt: 1\nname: coarse\ntime: {{initial: 0, final: 1}}\n{COARSE[what]}")
    assert solution.solved and solution.objective_error.bar > 0.05 * (1 + abs(solution.objective))
    assert "the error bar is" in solution.inaccurate
