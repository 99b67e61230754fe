"""A first mesh without a solution: more segments from the same guess are tried, and told."""

import json
import time
from dataclasses import replace

import pytest
from command_line import trajopt

from trajopt.transcription.loading import build_checked, load_yaml
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve

ALP_RIDER = """
trajopt: 1
name: alp rider
expressions:
  p(t0, b): exp(-b*(t - t0)**2)
time: {initial: 0, final: 20}
states:
  x1: {rate: -10*x1 + u1 + u2, initial: 2, final: 2}
  x2: {rate: -2*x2 + u1 + 2*u2, initial: 1, final: 3}
  x3: {rate: -3*x3 + 5*x4 + u1 - u2, initial: 2, final: 1}
  x4: {rate: 5*x3 - 3*x4 + u1 + 3*u2, initial: 1, final: -2}
controls: {u1: {}, u2: {}}
objective: {minimize: {integral: 100*(x1**2 + x2**2 + x3**2 + x4**2) + 0.01*(u1**2 + u2**2)}}
constraints:
  path:
    - name: terrain
      expression: "x1**2 + x2**2 + x3**2 + x4**2 - 3*p(3, 12) - 3*p(6, 10) - 3*p(10, 6) - 8*p(15, 4)"
      lower: 0.01
refine: {max_meshes: 1}
"""

WAVE = """
trajopt: 1
name: follow a wave
time: {initial: 0, final: 6}
states:
  POS: {rate: VEL, initial: 0}
  VEL: {rate: FORCE, initial: RATE}
controls: {FORCE: {lower: -LARGEST, upper: LARGEST}}
objective: {minimize: {integral: FORCE**2}}
constraints: {path: [{name: near the wave, expression: POS - sin(RATE*t), lower: -NEAR, upper: NEAR}]}
"""


def wave(rate: float, largest: float, near: float, names: str = "x v u") -> str:
    text = WAVE.replace("RATE", str(rate)).replace("LARGEST", str(largest)).replace("NEAR", str(near))
    for old, new in zip(("POS", "VEL", "FORCE"), names.split(), strict=True):
        text = text.replace(old, new)
    return text


def solved(folder, text: str, *arguments) -> dict:
    (folder / "problem.yaml").write_text(text)
    return json.loads(trajopt("solve", "problem.yaml", "--json", *arguments).stdout)


def test_a_mesh_that_crawls(folder):
    """The alp rider on 10 segments takes 2203 iterations, on 20 some 200; Betts: 2030.856."""
    summary = solved(folder, ALP_RIDER)
    assert summary["solved"] and summary["objective"] == pytest.approx(2031, abs=20)
    assert summary["meshes"][0]["segments"] == 20 and summary["meshes"][0]["iterations"] < 400
    assert summary["notes"] == ["10 segments from the start of the file led to no solution (it crawled); 20 did"]


@pytest.mark.parametrize("names", ["x v u", "height speed thrust"])
def test_a_mesh_that_holds_no_solution(names, folder):
    """Ten waves on ten segments: no polynomials of degree 4 follow them, those of twenty do."""
    summary = solved(folder, wave(10, 110, 0.05, names) + "refine: {max_meshes: 1}\n")
    assert summary["solved"] and summary["objective"] == pytest.approx(26628, rel=0.1)
    assert summary["meshes"][0]["segments"] == 20
    assert summary["notes"][0].endswith("(the constraints contradict each other near this point); 20 did")


def test_a_mesh_of_the_user_stays(folder):
    """Where no refinement follows, the result is of the mesh of the file, and the note tells how many do."""
    text = wave(5, 26, 0.03) + "mesh: [{method: hermite-simpson, segments: 10}]\n"
    summary = solved(folder, text)
    assert not summary["solved"]
    assert [mesh["segments"] for mesh in summary["meshes"]] == [10]
    assert summary["notes"][0].endswith(", 20 did: take as many")
    assert solved(folder, text, "--segments", "20")["solved"]


def test_what_cannot_be_followed_on_any_mesh_is_told_as_before(folder):
    """The wave asks for accelerations up to 25: no number of segments makes 5 enough."""
    summary = solved(folder, wave(5, 5, 0.03) + "mesh: [{method: trapezoid, segments: 10}]\n")
    assert not summary["solved"] and summary["violations"]
    assert not any("segments" in note for note in summary["notes"])


BIOREACTOR = """
trajopt: 1
name: growth on a substrate with a feed
parameters: {mu: 2.0, K: 0.2, d: 0.05, Y: 0.5}
time: {initial: 0, final: 30}
states:
  S: {rate: F - mu/Y*S*X/(K + S), initial: 5, lower: 0}
  X: {rate: mu*S*X/(K + S) - d*X, initial: 0.1, lower: 0}
controls: {F: {lower: 0, upper: 1}}
objective: {maximize: {integral: X - 2*F}}
"""

TREATMENT = """
trajopt: 1
name: treatment of a virus
parameters: {s1: 2.0, s2: 1.5, mu: 0.002, k: 2.5e-4, g: 30, B1: 14, B2: 1, A1: 2.5e5, A2: 75, c: 0.007}
time: {initial: 0, final: 50}
states:
  T: {rate: s1 - s2*V/(B1 + V) - mu*T - k*V*T + u1*T, initial: 400}
  V: {rate: g*(1 - u2)*V/(B2 + V) - c*V*T, initial: 3}
controls: {u1: {lower: 0, upper: 0.02}, u2: {lower: 0, upper: 0.9}}
objective: {maximize: {integral: T - A1*u1**2 - A2*u2**2}}
"""


@pytest.mark.parametrize(("half", "best"), [(0.2, 128.3427), (1.0, 127.9444)])
def test_growth_that_ends_at_once(half, best, folder):
    """Neither the start of the file nor 10 segments hold the end of growth; simulated states on 20 do."""
    summary = solved(folder, BIOREACTOR, "--set", f"parameters.K={half}")
    assert summary["solved"] and summary["objective"] == pytest.approx(best, abs=0.01)
    assert any("this is the solution from another on 20" in note for note in summary["notes"])


def test_few_segments_contradict_what_more_do_not(folder):
    """No constraint has to give way where the trajectory under a constant feed satisfies all."""
    (folder / "problem.yaml").write_text(BIOREACTOR)
    explained = trajopt("explain", "problem.yaml")
    assert explained.exit_code == 0 and "the constraints can all hold" in explained.stdout


def test_a_solution_that_is_no_trajectory(folder):
    """On 10 segments V passes the pole at V = -1; PROPT's manual: 29514.4477 for Joshi's model (2002)."""
    summary = solved(folder, TREATMENT)
    assert summary["solved"] and summary["objective"] == pytest.approx(29514.4477, abs=0.01)
    assert any("was no trajectory of the dynamics" in note for note in summary["notes"])


def test_a_time_limit_is_of_all_that_is_tried():
    """The refined mesh after 10 segments takes until the limit: nothing is solved on more segments then."""
    seen, began, seconds = [], time.monotonic(), 3.0

    def late(number, record):
        seen.append(number)
        while number and time.monotonic() < began + seconds + 0.1:
            time.sleep(0.1)

    spec = load_yaml(TREATMENT)
    settings = replace(settings_of(spec), seconds=seconds)
    solution = solve(build_checked([spec])[0], schedule_of(spec), settings, progress=late)
    assert 0 not in seen[seen.index(1) :] if 1 in seen else not solution.solved
    assert "time limit" in solution.stopped or not solution.solved


def test_what_more_segments_led_to_is_kept_when_interrupted():
    """On 10 segments, on the meshes after it, on 20 from the start, and then interrupted on the next mesh."""
    rounds = [[0]]

    def watched(number, record):
        if number < rounds[-1][-1]:
            rounds.append([])
        rounds[-1].append(number)

    spec = load_yaml(TREATMENT)
    solution = solve(
        build_checked([spec])[0], schedule_of(spec), settings_of(spec),
        progress=watched, stop=lambda: len(rounds) > 1 and 1 in rounds[-1],
    )  # fmt: skip
    assert solution.solved and not solution.is_no_trajectory and "interrupted" in solution.stopped
    assert solution.objective == pytest.approx(29514.4477, rel=1e-2)


WASHOUT = """
trajopt: 1
name: an enzyme without a bound on its substrate
parameters: {V: 20, Km: 0.5}
time: {initial: 0, final: 20}
states:
  s: {rate: u - V*s/(Km + s), initial: 50}
  p: {rate: V*s/(Km + s) - 0.3*p, initial: 0}
controls: {u: {lower: 0, upper: 5}}
objective: {maximize: {integral: p - 0.1*u**2}}
"""


def test_no_error_bar_across_a_pole(folder):
    """Past s = -Km the reaction makes substrate: 1104, where 394.3021 is the best with s >= 0."""
    summary = solved(folder, WASHOUT)
    assert summary["objective_error"] is None and summary["inaccurate"]
    assert any("which changes its sign" in note for note in summary["notes"])
    bounded = solved(folder, WASHOUT.replace("initial: 50", "initial: 50, lower: 0"))
    assert not bounded["inaccurate"] and bounded["objective"] == pytest.approx(394.3021, abs=1e-3)
