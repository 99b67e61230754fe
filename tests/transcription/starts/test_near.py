"""Starting from the multipliers of a solved neighbour: what they foretell and save, and what if they are wrong."""

import json
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from command_line import trajopt

from trajopt.results.sweep.axes import Axis
from trajopt.results.sweep.case import Task, solve_case
from trajopt.results.sweep.plan import grid
from trajopt.results.sweep.small import BROKEN, packed, unpacked
from trajopt.transcription.continuation import solve_spec
from trajopt.transcription.engines.outcome import Start, Status
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.loading import build_checked, load_yaml
from trajopt.transcription.starts.near import Near, solved_from, what_is_left
from trajopt.transcription.transcribe import program

SWING = """
trajopt: 1
name: swing
parameters: {l: 0.5, u_max: 12, bound: 1.9}
time: {initial: 0, final: 2}
states:
  q: {rate: w, initial: 0, final: pi}
  w: {rate: -9.81/l*sin(q) + u, initial: 0, final: 0, upper: 5}
controls: {u: {lower: -u_max, upper: u_max}}
constraints: {path: [{expression: w - 0.1*u, upper: 5.5}]}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 20}]
"""


def built(*overrides):
    spec = load_yaml(SWING, overrides)
    return spec, build_checked([spec])[0]


@pytest.fixture(scope="module")
def solved():
    return solve_spec(*built())


def again(solved, left, *overrides):
    return solve_spec(*built(*overrides), guess=solved.trajectories, near=left)


class Foretelling(Near):
    """A neighbour whose multipliers are believed to be good, whatever they are."""

    def foretold(self, *program):
        return self.objective


def foretold(solved, *overrides):
    """The objective that a solution foretells, for the problem with other numbers."""
    _, problems = built(*overrides)
    transcription, nlp, _ = program(problems[0], [t.mesh for t in solved.trajectories], solved.trajectories)
    left = what_is_left(solved)
    assert left.fits(transcription, nlp)
    return left.foretold(nlp, *bounded_start(transcription))


@pytest.mark.parametrize(
    ("path", "value"), [("parameters.l", 0.5), ("parameters.u_max", 12.0), ("states.w.upper", 5.0), ("time.final", 2.0)]
)
def test_the_objective_is_foretold_to_the_second_order(solved, path, value):
    """Numbers in functions, in bounds of unknowns, and given times: half the step leaves a quarter of the error."""
    assert foretold(solved) == pytest.approx(solved.objective, rel=1e-6)
    errors, changes = [], []
    for step in (0.008, 0.004):
        changed = f"{path}={value * (1 - step)}"
        objective = solve_spec(*built(changed), guess=solved.trajectories).objective
        errors.append(abs(foretold(solved, changed) - objective))
        changes.append(abs(objective - solved.objective))
    assert errors[1] < 0.4 * errors[0] + 1e-6 and errors[0] < 0.2 * changes[0]


@pytest.mark.parametrize("changed", ["time.final=2.02", "parameters.u_max=12.2"])
def test_multipliers_save_iterations_and_lead_to_the_same_point(solved, changed):
    plain, warm = again(solved, None, changed), again(solved, what_is_left(solved), changed)
    assert warm.solved and warm.outcome.count < 0.8 * plain.outcome.count
    assert warm.objective == pytest.approx(plain.objective, rel=1e-8)
    assert warm.outcome.z == pytest.approx(plain.outcome.z, abs=1e-3)


@pytest.mark.parametrize("changed", ["parameters.u_max=11.5", "states.w.upper=4.8", "parameters.l=0.6"])
def test_a_neighbour_is_not_close_that_passes_a_bound_or_is_much_better(solved, changed):
    """There multipliers would cost iterations, up to four times as many."""
    assert np.isnan(foretold(solved, changed))
    plain, warm = again(solved, None, changed), again(solved, what_is_left(solved), changed)
    assert np.array_equal(plain.outcome.z, warm.outcome.z) and plain.outcome.count == warm.outcome.count


@pytest.mark.parametrize("mesh", ["{method: hermite-simpson, segments: 21}", "{method: trapezoid, segments: 20}"])
def test_multipliers_of_another_mesh_are_left_alone(solved, mesh):
    plain, warm = (again(solved, left, f"mesh=[{mesh}]") for left in (None, what_is_left(solved)))
    assert np.array_equal(plain.outcome.z, warm.outcome.z) and plain.meshes[0].iterations == warm.meshes[0].iterations


def test_multipliers_that_lead_nowhere_are_dropped_and_their_iterations_count(solved):
    plain = again(solved, None, "time.final=2.02")
    wrong = what_is_left(solved)
    y = 1e9 * np.sin(np.arange(len(wrong.start.y)))
    wrong = Foretelling(wrong.points, wrong.objective, Start(y, wrong.start.z_lower, wrong.start.z_upper))
    warm = again(solved, wrong, "time.final=2.02")
    assert warm.solved and warm.objective == pytest.approx(plain.objective, rel=1e-8)
    assert warm.meshes[0].iterations >= plain.meshes[0].iterations


@pytest.mark.parametrize(
    ("first", "second", "kept", "more"),
    [
        ((Status.SOLVED, 1.0), None, 1.0, 0),  # better than foretold
        ((Status.SOLVED, 90.0), (Status.SOLVED, 80.0), 80.0, 9),
        ((Status.SOLVED, 90.0), (Status.SOLVED, 95.0), 90.0, 9),
        ((Status.SOLVED, 90.0), (Status.INFEASIBLE, 0.0), 90.0, 9),
        ((Status.INFEASIBLE, 1.0), (Status.SOLVED, 95.0), 95.0, 9),
        ((Status.ACCEPTABLE, 1.0), (Status.SOLVED, 95.0), 95.0, 9),
        ((Status.INFEASIBLE, 1.0), (Status.MAX_ITERATIONS, 95.0), 95.0, 9),
        ((Status.INTERRUPTED, 1.0), None, 1.0, 0),
    ],
)
def test_what_is_worse_than_foretold_is_solved_without_multipliers_and_the_better_kept(
    solved, first, second, kept, more
):
    """times: the objective, of which the neighbour foretells 10 %, or the other way round."""
    transcription, nlp, _ = program(solved.problem, [t.mesh for t in solved.trajectories], solved.trajectories)
    left = what_is_left(solved)
    record = {"iteration": np.arange(10)}
    outcomes = iter(replace(solved.outcome, status=s, objective=solved.objective * v / 50, iterations=record)
                    for s, v in filter(None, (first, second)))  # fmt: skip
    asked = []

    def run(options, start):
        asked.append((options, start))
        return next(outcomes)

    found, others = solved_from(left, run, nlp, *bounded_start(transcription), {"max_iter": 7, "tol": 1e-8})
    assert found.objective == pytest.approx(solved.objective * kept / 50) and others == more
    assert asked[0][1] is left.start and asked[0][0]["max_iter"] == 7
    assert asked[1:] == ([({"max_iter": 7, "tol": 1e-8}, None)] if second else [])


def chained(**kept):
    """Two neighbours of a sweep, the second from the first as its small result has it."""
    task = partial(Task, text=SWING, file="swing.yaml", overrides=(), chain=True)
    one = solve_case(task(0, {"parameters.u_max": "12"}))
    _, left = unpacked(packed(json.dumps(one.record).encode(), replace(one.left, **kept)))
    return one, left, solve_case(task(1, {"parameters.u_max": "12.2"}, origin=(0, left)))


def test_a_chained_case_starts_from_the_multipliers_of_its_neighbour():
    one, left, two = chained()
    assert one.left.near and np.array_equal(left.near.start.y, one.left.near.start.y)
    assert left.near.objective == one.left.near.objective
    _, none, plain = chained(near=None)  # as a folder of an older version has it
    assert none.near is None and two.record["iterations"] < 0.8 * plain.record["iterations"]
    assert two.record["objective"] == pytest.approx(plain.record["objective"], rel=1e-8)
    assert two.record["start"] == "case 0"


def test_foreign_multipliers_are_no_multipliers(solved):
    """Text is a broken file; what is not finite foretells nothing, and is not started from."""
    one, left, _ = chained()
    text = replace(left.near, start=replace(left.near.start, y=np.array(["a", "b"])))
    with pytest.raises(BROKEN):
        unpacked(packed(json.dumps(one.record).encode(), replace(one.left, near=text)))
    for wrong in (np.nan, np.inf):
        y = np.full_like(what_is_left(solved).start.y, wrong)
        strange = replace(what_is_left(solved), start=replace(what_is_left(solved).start, y=y))
        plain, warm = (again(solved, own, "time.final=2.02") for own in (None, strange))
        assert np.array_equal(plain.outcome.z, warm.outcome.z)


def test_only_chained_cases_keep_multipliers():
    answer = solve_case(Task(0, {}, SWING, "swing.yaml", ()))
    assert answer.record["solved"] and answer.left.curves and answer.left.near is None


def test_a_continuation_passes_multipliers_on():
    way = solve_spec(*built("continuation={time.final: [2.03, 2.02, 2.01]}"))
    alone = solve_spec(*built())
    assert way.solved and way.objective == pytest.approx(alone.objective, rel=1e-8)
    assert max(step.iterations for step in way.continuation[1:]) <= alone.outcome.count / 2


def test_a_chained_sweep_is_the_same_whatever_the_number_of_workers(folder):
    Path("swing.yaml").write_text(SWING)
    axes = ["--over", "parameters.u_max=12:12.2:3", "--over", "time.final=2,2.02", "--chain", "-q"]
    cases = []
    for jobs in ("1", "2"):
        assert trajopt("sweep", "swing.yaml", *axes, "-j", jobs, "-o", jobs).exit_code == 0
        files = sorted(Path(jobs, "cases").iterdir())
        cases.append([(file.name, unpacked(file.read_bytes())) for file in files])
    assert len(cases[0]) == 6
    for (name, (one, mine)), (other_name, (two, yours)) in zip(*cases, strict=True):
        assert name == other_name and one | {"seconds": 0} == two | {"seconds": 0}
        assert np.array_equal(mine.near.start.y, yours.near.start.y)
        assert np.array_equal(mine.curves["main"].values["u"], yours.curves["main"].values["u"])


def along(path, values):
    """What the cases with these values of a path leave, each solved from its guess."""
    tasks = (Task(i, {path: value}, SWING, "swing.yaml", (), chain=True) for i, value in enumerate(values))
    return [solve_case(task).left for task in tasks]


@pytest.mark.parametrize(("path", "values"), [("parameters.u_max", "12 12.1 12.2"), ("time.final", "2 2.02 2.03")])
def test_two_neighbours_foretell_the_next_to_the_second_order(path, values):
    """Curves, times, and multipliers: what is missed is a small part of the step."""
    values = values.split()
    plan = grid([Axis(path, tuple(values))])
    first, second, third = along(path, values)
    ahead = second.ahead(first, plan.share(0, 1, 2))
    for name, curve in third.curves["main"].values.items():
        missed, step = (np.abs(own.curves["main"].values[name] - curve).max() for own in (ahead, second))
        assert missed < 0.3 * step + 1e-6
    assert ahead.curves["main"].final_time == pytest.approx(third.curves["main"].final_time, rel=1e-12)
    missed, step = (np.abs(own.near.start.y - third.near.start.y).max() for own in (ahead, second))
    assert missed < 0.3 * step
    assert min(ahead.near.start.z_lower.min(), ahead.near.start.z_upper.min()) >= 0


def test_what_has_other_points_or_no_multipliers_foretells_nothing():
    first, second = along("parameters.u_max", ["12", "12.1"])
    own, near = first.curves["main"], first.near
    unnamed = replace(own, values={"q": own.values["q"]})
    fewer = replace(near, points=tuple(points[::2] for points in near.points))
    shorter = replace(near, start=replace(near.start, y=near.start.y[1:]))
    others = [replace(first, curves=curves) for curves in ({"main": unnamed}, {})]
    for other in (*others, *(replace(first, near=own) for own in (fewer, shorter))):
        assert second.ahead(other, 1.0) is second
    assert second.ahead(replace(first, near=None), 1.0) is second


def test_a_case_starts_from_what_both_neighbours_foretell(folder):
    """In a sweep, where that leads to the same optimum in fewer iterations than each neighbour alone."""
    Path("swing.yaml").write_text(SWING)
    records = {}
    for name, values in (("line", "12,12.1,12.2,12.3,12.4,12.5"), ("alone", "12.4,12.5")):
        run = trajopt("sweep", "swing.yaml", "--over", f"parameters.u_max={values}", "--chain", "-q", "-o", name)
        assert run.exit_code == 0
        records[name] = [json.loads(line) for line in Path(name, "index.jsonl").read_text().splitlines()]
    line, alone = records["line"][-1], records["alone"][-1]
    assert line["values"] == alone["values"] and line["start"] == "case 4"
    assert line["objective"] == pytest.approx(alone["objective"], rel=1e-8)
    assert line["iterations"] < alone["iterations"]


OF_POSITIVE = """
trajopt: 1
name: of a positive state
parameters: {p: 3}
time: {initial: 0, final: 1}
states: {x: {rate: u}}
controls: {u: {}}
objective: {minimize: {integral: (GROWING - p)**2 + 0.01*u**2}}
mesh: [{method: radau, segments: 4}]
guess: {constants: {x: 20}}
"""


@pytest.mark.parametrize(
    ("growing", "values"), [("log(x)", "3,1.5,0,-1.5"), ("sqrt(x)", "4,2,0.5,0.4"), ("x**0.3", "3,1.5,0.4")]
)
def test_a_case_that_fails_from_what_is_foretold_starts_from_its_neighbour(growing, values, folder):
    """The line through 20 and 4.5 leads to a negative x, where the function has no value."""
    Path("positive.yaml").write_text(OF_POSITIVE.replace("GROWING", growing))
    run = trajopt("sweep", "positive.yaml", "--over", f"parameters.p={values}", "--chain", "-q", "-o", "s")
    records = [json.loads(line) for line in Path("s", "index.jsonl").read_text().splitlines()]
    assert run.exit_code == 0 and all(record["objective"] < 1e-8 for record in records)
    assert [record["start"] for record in records] == ["guess", *(f"case {i}" for i in range(len(records) - 1))]
