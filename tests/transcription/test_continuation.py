"""Continuation: easier problems on the way, smaller steps where one fails, mistakes of the schedule."""

import time

import pytest

from trajopt.problems.errors import SpecError
from trajopt.transcription.continuation import solve_spec, way_of
from trajopt.transcription.engines.outcome import Status
from trajopt.transcription.loading import build_checked, load_yaml

SWING = """
trajopt: 1
name: swing
parameters: {g: {value: 9.81, unit: m/s^2}, far: 3.14159}
time: {initial: 0, final: 2}
states:
  q: {rate: w, initial: 0, final: far}
  w: {rate: u - g*sin(q), initial: 0, final: 0}
controls: {u: {lower: -40, upper: 40}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 10}, {method: hermite-simpson, segments: 20}]
"""


def solved(*overrides: str):
    spec = load_yaml(SWING, overrides)
    (problems,) = build_checked([spec])
    return solve_spec(spec, problems)


def test_each_problem_starts_from_the_one_before():
    alone, through = solved(), solved("continuation={parameters.g: [0, 5]}")
    assert [step.values["parameters.g"] for step in through.continuation] == [0, 5, 9.81]
    assert through.objective == pytest.approx(alone.objective, rel=1e-6)
    assert through.continuation[-1].objective == through.objective
    assert [record.mesh.segments for record in through.meshes] == [10, 20]  # of the file's own problem
    at_five = solved("parameters.g=5", "mesh=[{method: hermite-simpson, segments: 10}]")
    assert through.continuation[1].objective == pytest.approx(at_five.objective, rel=1e-6)


def test_several_values_go_together_and_the_file_s_own_may_be_among_them():
    spec = load_yaml(SWING, ["continuation={parameters.g: [0, 5, 9.81], time.final: [4, 3, 2]}"])
    assert way_of(spec) == {"parameters.g": [0, 5, 9.81], "time.final": [4, 3, 2]}
    assert solved("continuation={parameters.g: [0, 5], time.final: [4, 3]}").solved


def test_a_step_that_fails_is_halved_and_doubled_again():
    """Few iterations are enough for small steps only."""
    alone = solved("solver.max_iter=6")
    assert not alone.solved
    through = solved("solver.max_iter=6", "continuation={parameters.g: [0]}")
    g = [step.values["parameters.g"] for step in through.continuation]
    failed = [step for step in through.continuation if not step.status.usable]
    assert through.solved and failed and all(step.status is Status.MAX_ITERATIONS for step in failed)
    assert g[:3] == [0, 9.81, 9.81 / 2] and g[-1] == 9.81
    assert g == [0, 9.81, 9.81 / 2, 9.81, 0.75 * 9.81, 9.81]


def test_a_way_that_ends_nowhere_is_told():
    through = solved(
        "controls.u={lower: -1, upper: 1}",
        "continuation={controls.u.upper: [40], controls.u.lower: [-40]}",
        "solver.max_iter=15",  # what would have to give way is not asked then
    )
    assert not through.solved and through.continuation[0].status.usable
    last = through.continuation[-1]
    assert not last.status.usable and last.values["controls.u.upper"] > 1
    told = f"of a problem of continuation:, controls.u.upper = {last.values['controls.u.upper']:g}, controls.u.lower = "
    assert told in through.notes[-1] and "that of the file was not reached" in through.notes[-1]


@pytest.mark.parametrize(
    "way", ["continuation={parameters.g: [5]}", "complementarity=[{a: q**2, b: 0*q, relax: [1, 0.1]}]"]
)
def test_starts_are_drawn_for_the_first_problem_of_the_way(way):
    through = solved(way, "solver.starts=2", "solver.seed=1")
    assert through.solved
    assert through.notes[0].startswith("of the first problem on the way: 3 starts on the first mesh led to ")
    assert not any("starts" in note for note in through.notes[1:])


@pytest.mark.parametrize(
    ("schedule", "first"),
    [
        ("{parameters.g: [9, 5]}", "parameters.g = 9"),
        ("{parameters.far: [200], parameters.g: [0]}", "parameters.far = 200, parameters.g = 0"),
    ],
)
def test_a_first_problem_that_is_not_solved_is_not_taken_for_that_of_the_file(schedule, first):
    through = solved(f"continuation={schedule}", "solver.max_iter=2")
    assert not through.solved and len(through.continuation) == 1
    assert f"all this is of the first problem of continuation:, {first}, which is not solved" in through.notes[-1]


def test_nothing_is_told_of_a_way_that_reaches_the_file():
    through = solved("continuation={parameters.g: [5]}")
    assert through.solved and not any("continuation" in note for note in through.notes)


@pytest.mark.parametrize(
    ("continuation", "way"),
    [
        ("{parameters.g: [0, 5, 9.81], parameters.far: [4, 3, 2]}", [[0, 5, 9.81, 9.81], [4, 3, 2, 1]]),
        ("{parameters.g: [0, 5, 9.81], parameters.far: [3, 2]}", [[0, 5, 9.81], [3, 2, 1]]),
        ("{parameters.g: [0, 9.81], parameters.far: [3, 1]}", [[0, 9.81], [3, 1]]),
    ],
)
def test_lists_are_of_one_length_with_and_without_the_values_of_the_file(continuation, way):
    spec = load_yaml(SWING, ["parameters.g=9.81", "parameters.far=1", f"continuation={continuation}"])
    assert [*way_of(spec).values()] == way


@pytest.mark.parametrize(
    ("continuation", "says"),
    [
        ("{parameters.h: [0]}", "parameters.h is no number"), ("{parameters: [0]}", "parameters is no number"),
        ("{parameters.g: [0], parameters.far: [1, 2]}", "do not have one length"),
        ("{time.final: [-1]}", "is not after the initial time"), ("{states.w.rate: [1]}", "is no number in this file"),
        ("{parameters.g: []}", "at least 1"), ("{parameters.g: [a]}", "must be a number"), ("3", "must be a mapping"),
    ],
)  # fmt: skip
def test_mistakes_of_a_schedule(continuation, says):
    with pytest.raises(SpecError, match=says) as error:
        build_checked([load_yaml(SWING, [f"continuation={continuation}"])])
    assert all(m.where.startswith("--set continuation") and m.remedy for m in error.value.mistakes)


@pytest.mark.parametrize(
    ("path", "remedy"),
    [("g", "write parameters.g"), ("x.final", "write states.x.final"), ("parameter.g", "did you mean parameters.g?"),
     ("initial", "name one number: time.initial, states.x.initial"), ("h", "name a number, such as parameters.")],
)  # fmt: skip
def test_a_path_that_leaves_something_out_is_given_whole(path, remedy):
    text = """\
trajopt: 1
parameters: {g: 9.81}
time: {initial: 0, final: 1}
states: {x: {rate: u - g, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
"""
    with pytest.raises(SpecError) as error:
        build_checked([load_yaml(f"{text}continuation: {{{path}: [1]}}")])
    (mistake,) = error.value.mistakes
    assert remedy in mistake.remedy and f"{path} is no number" in mistake.what


def test_a_file_without_parameters_is_told_a_number_that_it_has():
    text = """\
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
continuation: {parameters.g: [1]}
"""
    with pytest.raises(SpecError) as error:
        build_checked([load_yaml(text)])
    assert error.value.mistakes[0].remedy == "name a number, such as time.initial"


def test_names_that_only_look_like_keys():
    """A parameter whose name is that of a key; a state whose name begins like one."""
    text = SWING.replace("far: 3.14159}", "far: 3.14159, relax: 1}").replace("u - g*sin(q)", "u - relax*g*sin(q)")
    spec = load_yaml(text, ["continuation={parameters.relax: [-1]}", "solver.max_iter=9"])
    found = solve_spec(spec, build_checked([spec])[0])
    assert all(isinstance(step.values["parameters.relax"], float) for step in found.continuation)
    text = SWING.replace("q:", "timer:").replace("sin(q)", "sin(timer)").replace("{rate: w", "{rate: w", 1)
    waypoint = "waypoints=[{time: 1, timer: 1.5}]"
    assert list(way_of(load_yaml(text, [waypoint, "continuation={waypoints.0.timer: [1]}"]))) == [
        "waypoints.0.states.timer"
    ]


def test_the_time_limit_is_for_the_whole_way():
    """Each step has what is left of it, so that the way ends soon after the limit."""
    limit = 0.3
    steps = ", ".join(f"{0.1 * k:.1f}" for k in range(90))
    began = time.monotonic()
    through = solved(f"solver.seconds={limit}", f"continuation={{parameters.g: [{steps}]}}")
    assert not through.solved and through.status is Status.TIME_LIMIT
    assert len(through.continuation) < 90 and time.monotonic() - began < 60
    assert [step.status for step in through.continuation[:-1]] == [Status.SOLVED] * (len(through.continuation) - 1)
