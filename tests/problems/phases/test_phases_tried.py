"""What users of phases ran into: kinds of fault, each with the case and others like it."""

import re

import numpy as np
import pytest
from repository import ROOT

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.results.file.guess import guess_from
from trajopt.results.file.summary import summarize
from trajopt.results.verify import verify
from trajopt.transcription.loading import build_checked, load_yaml
from trajopt.transcription.settings import schedule_of
from trajopt.transcription.solve import solve

from .phased import CURVE, MOVE, loaded, solved, written

DOCS = (ROOT / "docs" / "phases.md").read_text()
SWING = """
trajopt: 1
states: {q: {accel: u, velocity: {name: w, initial: 0, final: 0}, initial: 0, final: 1}}
controls: {u: {}}
time: {initial: 0, final: 1}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 6}]
"""


def test_the_example_of_the_docs_is_solved():
    text = re.search(r"```yaml\n(trajopt.*?)```", DOCS, re.DOTALL)[1]
    solution = solved(text)
    assert solution.trajectories[1].x[2, 0] == pytest.approx(solution.trajectories[0].x[2, -1] - 1500)


@pytest.mark.parametrize(
    "waypoint", ["{time: 0.5, q: 0.8, w: 0}", "{time: 0.5, w: 0, q: 0.8}", "{time: 0.5, states: {q: 0.8, w: 0}}"]
)
def test_a_waypoint_gives_position_and_velocity_of_one_state(waypoint):
    """12 (d/T^2)^2 T for each move from rest to rest: 12 (0.64 + 0.04)/0.125."""
    solution = solved(SWING, f"waypoints=[{waypoint}]")
    assert solution.objective == pytest.approx(12 * (0.8**2 + 0.2**2) / 0.5**3, rel=1e-8)


@pytest.mark.parametrize("methods", [("finite-difference", "radau"), ("trapezoid", "finite-difference")])
def test_finite_differences_beside_collocation_keep_velocities(methods):
    text = SWING + "phases: {a: {time: {final: 0.5}}, b: {}}\n"
    own = [f"phases.{name}.mesh=[{{method: {m}, segments: 20}}]" for name, m in zip("ab", methods, strict=True)]
    a, b = (solution := solved(text, *own)).trajectories
    assert solution.objective == pytest.approx(CURVE, rel=0.05)
    assert a.x[1, -1] == pytest.approx(b.x[1, 0], rel=0.1) and a.x[1, -1] > 1


def test_finite_differences_beside_shooting_are_refused():
    text = SWING + "phases: {a: {time: {final: 0.5}, mesh: [{method: runge-kutta-4, segments: 4}]}, b: {}}\n"
    with pytest.raises(SpecError, match="finite differences have no velocities"):
        build_checked([load_yaml(text, ["mesh=[{method: finite-difference, segments: 5}]"])])


@pytest.mark.parametrize("method", ["hermite-simpson", "runge-kutta-4"])
def test_a_fixed_time_is_not_the_guess_s(method):
    """Curves of another duration, as on the way of a continuation, leave a fixed time alone."""
    mesh = f"mesh=[{{method: {method}, segments: 4}}]"
    before = solved(SWING, mesh, "time.final=2")
    spec = load_text(SWING, "x.yaml", [mesh])
    after = solve(build(spec), schedule_of(spec), guess=before.trajectories)
    assert after.trajectories[0].t.tolist() == [0, 1] and after.objective == pytest.approx(CURVE, rel=1e-6)


REST = """
trajopt: 1
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
time: {initial: 0, final: {lower: 1.5, upper: 9, guess: 4}}
phases: {go: {}, rest: {controls: {u: {lower: 0, upper: 0}}}, move: {}}
objective: {minimize: {integral: u**2, terminal: "0.25*t[final]"}}
mesh: [{method: hermite-simpson, segments: 3}]
"""


@pytest.mark.parametrize(
    "duration",
    [
        'phases.rest.constraints={boundary: [{expression: "t[final] - t[initial]", equals: 1}]}',
        'constraints={boundary: [{expression: "rest.t[final] - rest.t[initial]", equals: 1}]}',
        'links=[{expression: "rest.t[final] - rest.t[initial]", equals: 1}]',
    ],
)
def test_a_fixed_duration_says_nothing_of_h(duration, tmp_path):
    """A rest of a fixed duration between two moves: both its ends are free, and H jumps at them."""
    spec = load_text(REST, "x.yaml", [duration])
    solution = solve(build(spec), schedule_of(spec))
    assert solution.objective == pytest.approx(1.25, rel=1e-6)  # 1/T + (T + 1)/4 with T = 2
    assert all(check.passed for check in verify(written(solution, spec, tmp_path)))


@pytest.mark.parametrize(
    ("edit", "says"),
    [
        ("guess={keyframes: {time: [0, 1], x: [0, 1], v: [0, 2, 1]}}", "v has 3 keyframes, time has 2"),
        ("guess={keyframes: {time: [0, 1], x: [0, 1, 2]}}", "x has 3 keyframes, time has 2"),
        ("guess={keyframes: {time: [0, 2, 1], x: [0, 1, 2]}}", "the times do not increase"),
        ("guess={keyframes: {y: [0, 1]}}", "y is not a state or a control of any phase"),
        ("guess={keyframes: {x: [0, q]}}", 'unknown name "q"'),
        ("phases.second.without=[w]", "the top level has no w"),
        ("links=[{from: first, to: second, except: [u]}]", 'no state "u" to leave out'),
        ("phases.secnd.time.final=3", "phases has no secnd; did you mean second"),
    ],
)
def test_what_was_taken_without_a_word_is_a_mistake(edit, says):
    with pytest.raises(SpecError, match=says):
        loaded(MOVE, edit)


def test_a_phase_that_does_not_go_on_in_time_needs_one():
    apart = "links=[{from: first, to: second, except: [t]}]"
    with pytest.raises(SpecError, match="nothing says when second begins"):
        loaded(MOVE, apart, "phases.second.time=", "phases.first.time.final=0.4")
    loaded(MOVE, apart, "phases.first.time.final=0.4")


def test_a_state_that_comes_back_begins_anew():
    text = MOVE.replace("first: {}", "first: {states: {w: {rate: u, initial: 2}}}\n  middle: {without: [v]}")
    text = text.replace("states:\n  x: {rate: v", "states:\n  x: {rate: u")
    first, middle, second = build(loaded(text)).phases
    assert [s.name for s in middle.states] == ["x"]
    assert [s.initial.fixed for s in first.states] == [True, True, True]
    assert second.states[1].name == "v" and second.states[1].initial.lower == 0  # as it begins there
    assert first.states[1].final.fixed and not first.states[0].final.fixed  # v ends with the first phase, x does not


def test_a_guess_of_other_phases_gives_its_part(tmp_path):
    one = load_text(SWING, "x.yaml")
    path = written(solve(build(one), schedule_of(one)), one, tmp_path)
    three = build(load_text(SWING + "waypoints: [{q: 0.2}, {q: 0.7}]\n", "x.yaml"))
    parts = guess_from(path, three)
    ends = [(g.values["q"][0], g.values["q"][-1]) for g in parts]
    assert ends[0][0] == pytest.approx(0, abs=1e-9) and ends[2][1] == pytest.approx(1)
    assert ends[0][1] == pytest.approx(ends[1][0]) == pytest.approx(7 / 27)  # 3 s^2 - 2 s^3 at a third
    back = solve(three, [schedule_of(one)[0][0]], guess=parts)
    several = load_text(SWING + "waypoints: [{q: 0.2}, {q: 0.7}]\n", "x.yaml")
    (whole,) = guess_from(written(back, several, tmp_path), build(one))
    assert np.interp([0, 0.5, 1], whole.s, whole.values["q"]) == pytest.approx([0, 0.5, 1], abs=0.02)


@pytest.mark.parametrize(
    ("objective", "extra", "optimum"),
    [("integral: u**2", "integral: 100 + u**2", 1.5), ("integral: u**2 + x**2/100", "integral: 7 + u**2", None)],
)
def test_a_phase_that_is_worth_nothing_shrinks_to_nothing(objective, extra, optimum):
    """With a lower bound of zero, between two others; the optimum is that of one phase."""
    one = f"""\
trajopt: 1
time: {{initial: 0, final: 2}}
states:
  x: {{rate: v, initial: 0, final: 1}}
  v: {{rate: u, initial: 0, final: 0}}
controls: {{u: {{}}}}
objective: {{minimize: {{{objective}}}}}
"""
    ends = "time: {final: {lower: 0, upper: 2, guess: %s}}"
    phases = f"phases:\n  a: {{{ends % 0.7}}}\n  b: {{{ends % 1.3}, objective: {{minimize: {{{extra}}}}}}}\n  c: {{}}\n"
    solution, alone = (trajopt.solve(trajopt.load(text)) for text in (one + phases, one))
    times = solution.phases["b"].time
    assert solution.solved and times[-1] - times[0] < 1e-6
    assert solution.objective == pytest.approx(optimum or alone.objective, abs=1e-6)


THREE = """
trajopt: 1
states: {x: {rate: u, initial: 0}}
controls: {u: {}}
phases: {a: {time: {initial: 0, final: 1}}, b: {time: {final: 3}}, c: {time: {final: 4}}}
links:
  - {from: a, to: b}
  - {from: b, to: c, except: [x]}
  - {name: gate, expression: "a.x[final]", equals: 2}
  - {name: jump, expression: "c.x[initial] - b.x[final]", upper: 0.5}
constraints:
  boundary: [{name: reach, expression: "x[final]", lower: 4.5}, {name: idle, expression: "x[final]", upper: 9}]
objective: {minimize: {integral: u**2}}
mesh: [{method: METHOD, segments: 4}]
"""


@pytest.mark.parametrize("methods", ["radau", "runge-kutta-4", "phases.b.mesh.0.method=runge-kutta-4"])
def test_conditions_between_phases_have_a_price(methods, tmp_path):
    """J = g^2/1 + (r - j - g)^2/3 with g = 2, r = 4.5, j = 0.5: dJ/dg = 2g - 4/3, dJ/dr = 4/3 = -dJ/dj."""
    own = [methods] if "=" in methods else []
    text = THREE.replace("METHOD", "radau" if own else methods).replace(
        "b: {", "b: {mesh: [{method: radau, segments: 3}], "
    )
    spec = loaded(text, *own)
    solution = solved(text, *own)
    exact = {"gate": 4 - 4 / 3, "jump": -4 / 3, "reach": 4 / 3, "idle": 0}
    assert solution.prices_between == pytest.approx(exact, abs=1e-6)
    summary = summarize(written(solution, spec, tmp_path))
    assert summary["prices"] == pytest.approx(exact, abs=1e-6)
    assert "gate" not in summary["phases"]["a"]["prices"]


@pytest.mark.parametrize(
    "use",
    [
        'links: [{from: first, to: second}, {expression: "f(first.x[final])", equals: 0.25}]',
        'constraints: {boundary: [{expression: "f(x[final])", lower: 0.9}]}',
        'phases.second.constraints.boundary: [{expression: "f(x[final])", lower: 0.9}]',
    ],
)
def test_a_table_that_only_the_ends_use_is_used(use):
    tables = "tables: {f: {points: {x: [0, 1, 2]}, values: [0, 1, 4], outside: hold}}\n"
    key, _, value = use.partition(": ")
    own = [f"{key}={value}"] if "." in key else []
    spec = loaded(MOVE + tables + ("" if own else use), *own)
    assert not spec.warnings
    assert [w.what for w in loaded(MOVE + tables).warnings] == ["the table f is used nowhere"]


def test_the_table_of_meshes_names_the_methods_of_all_phases(tmp_path):
    spec = loaded(MOVE, "phases.first.mesh=[{method: radau, segments: 3}]")
    summary = summarize(written(solve(build(spec), schedule_of(spec)), spec, tmp_path))
    assert [mesh["method"] for mesh in summary["meshes"]] == ["radau, hermite-simpson"]
    assert [phase["method"] for phase in summary["phases"].values()] == ["radau", "hermite-simpson"]
