"""Controls that only switch, in a free time: starts on both sides of the own one are tried, where it is cheap."""

import pytest

import trajopt
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve


def aircraft(sign: int, first: float) -> str:
    """Garrard and Jordan's F-8 (mintOC), mirrored or not: x1, x3 and w times the sign leave the same times."""
    return f"""\
trajopt: 1
time: {{initial: 0, final: {{lower: 0.1, upper: 20, guess: 5}}}}
parameters: {{s: {sign}}}
states:
  a: {{rate: "s*(-0.877*(s*a) + s*q - 0.088*a*q + 0.47*a**2 - 0.019*b**2 - s*a**2*q + 3.846*s*a**3 - 0.215*s*w
    + 0.28*s*a**2*w + 0.47*s*a*w**2 + 0.63*s*w**3)", initial: {sign * first}, final: 0}}
  b: {{rate: q, initial: 0, final: 0}}
  q: {{rate: "s*(-4.208*s*a - 0.396*s*q - 0.47*a**2 - 3.564*s*a**3 - 20.967*s*w + 6.265*s*a**2*w
    + 46*s*a*w**2 + 61.4*s*w**3)", initial: 0, final: 0}}
controls: {{w: {{lower: -0.05236, upper: 0.05236}}}}
objective: {{minimize: {{terminal: "t[final]"}}}}
mesh: [{{method: radau, segments: 10, degree: 4}}]
"""


@pytest.mark.parametrize(("sign", "first", "least", "side"), [(1, 0.4655, 3.9, "above"), (-1, 0.4655, 3.9, "below")])
def test_the_better_switching_is_found(sign, first, least, side):
    solution = trajopt.solve(trajopt.load(aircraft(sign, first)))
    assert solution.objective < least
    assert f"another: controls {side} the middle" in " ".join(solution.notes)


@pytest.mark.parametrize("bound", [1, 3])
def test_a_single_optimum_is_not_told_of(bound):
    text = f"""\
trajopt: 1
time: {{initial: 0, final: {{lower: 0.1, upper: 20, guess: 5}}}}
states: {{q: {{rate: v, initial: 0, final: 1}}, v: {{rate: u, initial: 0, final: 0}}}}
controls: {{u: {{lower: -{bound}, upper: {bound}}}}}
objective: {{minimize: {{terminal: "t[final]"}}}}
mesh: [{{method: radau, segments: 10, degree: 4}}]
"""
    solution = trajopt.solve(trajopt.load(text))
    assert solution.objective == pytest.approx(2 / bound**0.5, rel=1e-3) and not solution.notes


@pytest.mark.parametrize(
    ("states", "objective"),
    [
        ("x: {rate: thrust, initial: 0}", "maximize: {terminal: 'x[final]'}"),
        ("x: {rate: v, initial: 0}, v: {rate: thrust - x, initial: 1}", "minimize: {integral: x}"),
        ("x: {rate: thrust - x, initial: 2}", "maximize: {integral: x, terminal: '2*x[final]'}"),
    ],
)
def test_what_runs_away_ends_soon(states, objective):
    text = f"""\
trajopt: 1
time: {{initial: 0, final: 1}}
states: {{{states}}}
controls: {{thrust: {{}}}}
objective: {{{objective}}}
"""
    spec = load_text(text, "away.yaml")
    solution = solve(build(spec), steps(spec.mesh), settings_of(spec))
    assert not solution.solved and sum(mesh.iterations for mesh in solution.meshes) < 300
    assert "thrust runs to" in solution.trouble or "x runs to" in solution.trouble
