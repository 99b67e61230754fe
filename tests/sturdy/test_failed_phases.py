"""Failed solves of files with phases, and phases that take no time: what is told, stored and read again."""

import json
import re

import pytest
from command_line import strict_json, trajopt

from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.results.file.summary import causes
from trajopt.transcription.settings import settings_of, steps
from trajopt.transcription.solve import solve

TWO = """
trajopt: 1
name: two phases
states: {x: {unit: m, rate: v}, v: {unit: m/s, rate: u}}
controls: {u: {}}
phases:
  first:
    time: {initial: 0, final: {lower: 0, upper: 1, guess: 0.3}}
    states: {x: {initial: 0}, v: {initial: 0}}
    controls: {u: {lower: 0, upper: 0}}
  second: {time: {final: 1}, states: {x: {final: 1}, v: {final: 0}}}
objective: {minimize: {integral: u**2}}
constraints: {boundary: [{name: early, expression: "first.t[final]", upper: 0.5}]}
mesh: [{method: hermite-simpson, segments: 6}]
solver: {starts: 1}
"""
LATE = TWO.replace("upper: 0.5}", "lower: 2}")
MANY = """
trajopt: 1
name: many that contradict each other
time: {initial: 0, final: 1}
states: {"x{i}": {for: i in 1..5, rate: "-x{i}", initial: 0, final: 1}}
objective: {minimize: {integral: x1**2}}
mesh: [{method: METHOD, segments: 4}]
"""


def solved(text):
    spec = load_text(text, "a.yaml")
    return solve(build(spec), steps(spec.mesh), settings_of(spec))


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Name of each text -> its result, and how `solve` ended."""
    folder = tmp_path_factory.mktemp("failed")
    made = {}
    for name, text in {"shrunk": TWO, "late": LATE, "many": MANY.replace("METHOD", "hermite-simpson")}.items():
        (folder / f"{name}.yaml").write_text(text)
        made[name] = folder / f"{name}.h5", trajopt("solve", folder / f"{name}.yaml", "-o", folder / f"{name}.h5")
    return made


@pytest.mark.parametrize("method", ["hermite-simpson", "mixed"])
def test_a_boundary_constraint_of_the_top_level_is_called_so(method):
    """Also where phases have methods of their own, so that programs are joined."""
    mesh = (
        "phases:\n  first:\n    mesh: [{method: runge-kutta-4, segments: 6}]"
        if method == "mixed"
        else "phases:\n  first:"
    )
    solution = solved(LATE.replace("phases:\n  first:", mesh))
    told = " ".join([*map(str, solution.violations), *solution.relief, solution.trouble])
    assert "boundary constraint 'early'" in told and "link 'early'" not in told
    assert "link 'x from first to second'" in told  # what nobody wrote is one still


def test_all_that_is_involved_is_in_json(results):
    path, run = results["many"]
    assert run.exit_code == 1 and "the initial values of x1, x2, x3, x4, x5, the final" in run.stdout
    assert " more" not in run.stdout.partition("remedy")[0]  # nobody has to guess which
    for told in (strict_json(trajopt("show", path, "--json").stdout),):
        assert told["involved"] == [f"the {end} value of x{i}" for i in range(1, 6) for end in ("initial", "final")]
        assert told["trouble"] == f"these cannot all hold: {', '.join(told['involved'])}"
        assert [own.partition(" between")[0] for own in told["violations"]] == [
            f"the dynamics of x{i}" for i in range(1, 6)
        ]
        assert " more" not in json.dumps(told)


def test_equations_that_say_the_same_are_all_named():
    """Seven constraints on one number, by an engine that needs them to be independent."""
    same = ", ".join(f"{{name: c{i}, expression: 'x[final]*{i}', equals: {i}}}" for i in range(1, 8))
    text = f"""
trajopt: 1
name: the same seven times
time: {{initial: 0, final: 1}}
states: {{x: {{rate: u + v, initial: 0}}}}
controls: {{u: {{}}, v: {{}}}}
objective: {{minimize: {{integral: u**2 + v**2}}}}
constraints: {{boundary: [{same}]}}
mesh: [{{method: hermite-simpson, segments: 6}}]
solver: {{engine: newton}}
"""
    solution = solved(text)
    assert not solution.solved and len(solution.involved) >= 2
    assert all(name in solution.trouble for name in solution.involved) and " more" not in solution.trouble


@pytest.mark.parametrize(
    ("names", "told"),
    [
        (["a0", "a1"], "a0, a1"),
        ([f"c{i}" for i in range(40)], ", ".join(f"c{i}" for i in range(40))),
        (
            ["the initial value of x", "the final value of x", "the initial value of v", "link 'a'"],
            "the initial values of x, v, the final value of x, link 'a'",
        ),
        (
            [
                "the lower bound of u between t = 0 and 1",
                "the lower bound of w between t = 0 and 1",
                "the upper bound of q",
            ],
            "the lower bounds of u, w between t = 0 and 1, the upper bound of q",
        ),
        (
            ["the final value of x of phase a", "the final value of v of phase a", "the final value of x of phase b"],
            "the final values of x, v of phase a, the final value of x of phase b",
        ),
    ],
)
def test_a_sentence_names_all_that_is_involved(names, told):
    assert causes(f"these: {', '.join(names)}; mend", [], names) == [f"these: {told}; mend"]


def test_a_phase_that_shrank_begins_and_ends_at_zero(results):
    path, run = results["shrunk"]
    shown = trajopt("show", path).stdout
    assert run.exit_code == 0
    assert "first: t = 0 to 0 s;" in shown and "second: t = 0 to 1 s;" in shown and "phase first: t = 0 to 0 s" in shown
    assert trajopt("verify", path).exit_code == 0
    for text in (run.stdout, shown, trajopt("verify", path).stdout):
        assert "e-1" not in "".join(part.split()[0] for part in text.split("t = ")[1:])
    ends = strict_json(trajopt("show", path, "--json").stdout)["phases"]["first"]["time"]
    assert abs(ends["final"]) < 1e-6  # as it was found


def test_a_phase_that_shrank_in_a_failed_solve_is_read_again(results):
    """Its times are in order but for rounding: the result was refused by the program that had written it."""
    path, run = results["late"]
    assert run.exit_code == 1 and "NOT SOLVED" in run.stdout
    assert "NOT SOLVED" in trajopt("show", path).stdout
    assert re.search(r"^FAIL +solver status", trajopt("verify", path).stdout, re.M)
