"""What `trajopt sweep` varies: ranges, lists, grids, tables and samples, and what is wrong in them."""

from pathlib import Path

import pytest
from command_line import trajopt

from trajopt.problems.errors import SpecError
from trajopt.results.sweep.axes import Axis, axis_of, parse_axis
from trajopt.results.sweep.check import looked_at
from trajopt.results.sweep.dataset import dimensions
from trajopt.results.sweep.plan import Plan, grid, listed_in_file, sampled, zipped

pytestmark = pytest.mark.usefixtures("folder")


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("a=8:20:4", ("8", "12", "16", "20")),
        ("a=1:2:3", ("1.0", "1.5", "2.0")),
        ("a=0.1:0.3:3", ("0.1", "0.2", "0.3")),
        ("a=2:-2:3", ("2", "0", "-2")),
        ("a=5:5:1", ("5",)),
        ("a=log:1:100:3", ("1", "10", "100")),
        ("a=log:1e-3:1e-1:3", ("0.001", "0.01", "0.1")),
        ("a= x , y ", ("x", "y")),
        ("a=7", ("7",)),
        ("a=min(1, 2),3", ("min(1, 2)", "3")),
        ("a={method: radau, segments: 3},null", ("{method: radau, segments: 3}", "null")),
        ('a="1:2",[3, 4]', ('"1:2"', "[3, 4]")),
    ],
)
def test_values(text, values):
    assert parse_axis(text).values == values


def test_a_section_of_a_file_says_the_same():
    assert axis_of("a", "8:20:4", "x") == axis_of("a", "8:20:4", "y")
    assert axis_of("a", [8, 9.5, "sin(1)", [1, 2]], "x").values == ("8", "9.5", '"sin(1)"', "[1, 2]")
    assert axis_of("a", 3, "x").values == ("3",)


WRONG = [
    (
        ["--over", "parameters.u_max"],
        "--over parameters.u_max: this is not PATH=VALUES; write parameters.u_max=8:20:25",
    ),
    (["--over", "=1:2:3"], "--over =1:2:3: this is not PATH=VALUES"),
    (["--over", "a="], "--over a=: this is not PATH=VALUES"),
    (["--over", "a=1:2"], '--over a: "1:2" is neither a range nor a list; write START:STOP:COUNT'),
    (["--over", "a=1:2:3:4"], '--over a: "1:2:3:4" is neither a range nor a list'),
    (["--over", "a=1:x:3"], '--over a: "x" is no number to start or end a range'),
    (["--over", "a=1:inf:3"], '--over a: "inf" is no number to start or end a range'),
    (["--over", "a=1:2:0"], '--over a: "0" is no COUNT of values; write a whole number from 1 to 1000000'),
    (["--over", "a=1:2:2.5"], '--over a: "2.5" is no COUNT of values'),
    (["--over", "a=1:1:3"], "--over a: the range starts and ends at 1; give another STOP"),
    (["--over", "a=log:0:1:3"], "--over a: a logarithmic range from 0 to 1 leaves the positive numbers"),
    (["--over", "a=log:1:2"], '--over a: "log:1:2" is neither a range nor a list'),
    (["--over", "a=1,,2"], "--over a: a value is missing between two commas, or at an end"),
    (["--over", "a=1,2,1.0,1"], "--over a: the number 1 is given twice; remove one of them"),
    (["--over", "a=[1"], "--over a: this is not YAML"),
    (["--over", "a=1,2", "--over", "a=3,4"], "--over a: the path is given twice; give all its values at once"),
    (["--over", "time.final=1,2", "--set", "time.final=1"], "--over time.final: the field is also set for all"),
    (["--over", "a=1:2:1000", "--over", "b=1:2:1001"], "--over: the grid has 1001000 cases; sweep at most 1000000"),
    (["--over", "a=1,2", "--over", "b=1,2,3", "--zip"], "--zip: the axes have different numbers of values: a has 2, b"),
    (["--over", "a=1,2", "--zip", "--sample", "3"], "--zip: a sample varies all axes by itself"),
    (["--over", "a=1,2", "--sample", "0"], '--sample: "0" is no number for it; write a whole number from 1'),
    (["--over", "a=1,2", "--seed", "3"], "--seed: there is no sample that it could be for"),
    (["--over", "a=1:2", "--sample", "3", "--seed", "x"], '--seed: "x" is no number for it'),
    (["--over", "a=1:2", "--sample", "3", "--chain"], "--chain: the cases of a sample have no neighbours"),
    (["--over", "a=1,2", "--list", "cases.csv"], "--list: the table has all cases; leave out --over"),
    ([], "sweep: nothing is varied; add --over PATH=START:STOP:COUNT, --list CSV, or a section sweep:"),
    (["--over", "time.final=1,2", "--shard", "0/2"], "--shard 0/2: this is no part of a sweep; write 1/8"),
    (["--over", "time.final=1,2", "--shard", "3/2"], "--shard 3/2: this is no part of a sweep"),
    (["--over", "time.final=1,2", "--shard", "1/2", "--chain"], "--shard: a case would wait for its neighbour"),
    (["--over", "time.final=1,2", "--shard", "1/2", "--force"], "--force: each shard would throw away what the others"),
    (["--over", "time.final=1,2", "-j", "0"], '--jobs: "0" is no number for it'),
    (["--over", "parameters.q=1,2"], "--over parameters.q=1: parameters has no q; "),
    (["--over", "mesh.0.method=radau,trap"], '--over mesh.0.method=trap: there is no method "trap"; write trapezoid'),
    (["--over", "mesh.0.segments=5:0:2"], "--over mesh.0.segments=0: 0 segments are asked for"),
    (["--over", "mesh.3.segments=5,6"], "--over mesh.3.segments=5: mesh has 1 entries, so there is no entry 3"),
    (["--over", "time.final=1,-1"], "--over time.final=-1: "),
    (["--over", "time.final=1,2", "--resume"], "block_move_min_force-sweep: there is no sweep to resume"),
]


@pytest.mark.parametrize(("arguments", "sentence"), WRONG, ids=lambda x: " ".join(x) if isinstance(x, list) else "")
def test_mistakes_are_told_once_and_before_anything_is_made(folder, arguments, sentence):
    result = trajopt("sweep", "block_move_min_force", *arguments)
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    assert result.stderr.startswith(f"error: {sentence}"), result.stderr
    assert result.stderr.count("\n") == 1
    assert not list(folder.iterdir())


def test_a_mistake_elsewhere_in_the_file_names_the_case():
    result = trajopt("sweep", "cartpole", "--over", "parameters.d_max=2,-3")
    assert result.exit_code == 2
    assert "error: --over parameters.d_max=-3: " in result.stderr and "states.q1" in result.stderr


TABLES = [
    ("", 2, "cases.csv: the file has no cases; write paths in its first line"),
    ("time.final\n", 2, "cases.csv: the file has no cases"),
    ("time.final,\n1,2\n", 2, "cases.csv:1: a column has no path"),
    ("time.final,a\n1,2\n1\n", 2, "cases.csv:3: the line has 1 values; give one for each of the 2 paths"),
    ("time.final,a\n1,\n", 2, "cases.csv:2: a value is missing"),
    ("time.final\n1\n2\n\n1\n", 2, "cases.csv:5: the case is that of line 2 again; remove one of them"),
    ("time.final,time.final\n1,2\n", 2, "--over time.final: the path is given twice"),
    (b"time.final\n\xff\n", 2, "cases.csv: this is not UTF-8 text"),
    (None, 3, "cases.csv: there is no such file; give a CSV file with --list"),
]


@pytest.mark.parametrize(("content", "code", "sentence"), TABLES)
def test_mistakes_in_a_table(content, code, sentence):
    if content is not None:
        Path("cases.csv").write_bytes(content if isinstance(content, bytes) else content.encode())
    result = trajopt("sweep", "block_move_min_force", "--list", "cases.csv")
    assert (result.exit_code, result.stdout) == (code, "")
    assert result.stderr.startswith(f"error: {sentence}"), result.stderr


def test_a_grid_and_the_neighbours_in_it():
    plan = grid([parse_axis("a=1,2,3"), parse_axis("b=x,y")])
    assert plan.shape == (3, 2)
    assert [plan.overrides(n) for n in (0, 1, 2)] == [["a=1", "b=x"], ["a=1", "b=y"], ["a=2", "b=x"]]
    assert [plan.before(n) for n in range(6)] == [None, 0, 0, 2, 2, 4]


def test_zipped_and_listed():
    plan = zipped([parse_axis("a=1:3:3"), parse_axis("b=x,y,z")])
    assert (plan.shape, plan.overrides(2), plan.before(2)) == ((3,), ["a=3", "b=z"], 1)
    Path("cases.csv").write_text('a,b\n1, "[1, 2]"\n2,y\n')
    plan = listed_in_file(Path("cases.csv"))
    assert plan.shape == (2,) and plan.overrides(1) == ["a=2", "b=y"]


def test_a_latin_hypercube_has_one_case_in_each_part_and_is_the_same_again():
    axes = [parse_axis("a=0:10", True), parse_axis("b=log:1:16:9"), parse_axis("c=x,y")]
    plan = sampled(axes, 8, 3)
    first = sorted(float(value) for value in plan.axes[0].values)
    assert [int(value / 1.25) for value in first] == list(range(8))
    assert sorted(plan.axes[2].values) == ["x"] * 4 + ["y"] * 4
    assert all(1 <= float(value) <= 16 for value in plan.axes[1].values)
    assert plan == sampled(axes, 8, 3) != sampled(axes, 8, 4)


def test_few_cases_of_a_large_sweep_are_looked_at_before_it_starts():
    plan = grid([parse_axis("a=0:1:1000"), parse_axis("b=x,y,z")])
    assert [plan.overrides(n) for n in looked_at(plan)] == [
        ["a=0.0", "b=x"], ["a=0.0", "b=y"], ["a=0.0", "b=z"], ["a=0.4994994994995", "b=x"], ["a=1.0", "b=x"]
    ]  # fmt: skip
    assert len(looked_at(sampled([parse_axis("a=0:1", True), parse_axis("b=0:1", True)], 1000, 0))) <= 5


def test_names_of_dimensions():
    assert dimensions(["parameters.u_max", "mesh.0.method"], []) == ["u_max", "method"]
    assert dimensions(["mesh.0.segments", "mesh.1.segments"], []) == ["mesh.0.segments", "mesh.1.segments"]
    assert dimensions(["solver.seconds"], ["seconds"]) == ["solver.seconds"]


def test_errors_survive_the_way_between_processes():
    import pickle

    with pytest.raises(SpecError) as error:
        parse_axis("a=1:2")
    again = pickle.loads(pickle.dumps(error.value))
    assert again.mistakes == error.value.mistakes and str(again) == str(error.value)


@pytest.mark.parametrize(
    ("design", "axes", "share"),
    [
        ("grid", [["1", "2", "3"]], 1.0),
        ("grid", [["1", "1.2", "1.5"]], 1.5),
        ("grid", [["a", "b", "c"]], None),
        ("grid", [["1", "2", "9"]], None),  # farther than is believed
        ("grid", [["1", "2", "1.5"]], None),  # back again
        ("grid", [["1", "2", "nan"]], None),
        ("grid", [["0", "0", "0"], ["1e-3", "2e-3", "3e-3"]], 1.0),
        ("zip", [["1", "2", "3"], ["1", "2", "3"]], None),  # not on one axis
        ("zip", [["7", "7", "7"], ["3", "2", "1"]], 1.0),
    ],
)
def test_the_step_to_a_case_as_a_part_of_the_one_before(design, axes, share):
    plan = Plan(design, tuple(Axis(f"p.{i}", tuple(values)) for i, values in enumerate(axes)))
    found = plan.share(0, 1, 2)
    assert found is share if share is None else found == pytest.approx(share)


def test_the_first_case_of_a_line_is_on_no_line_with_the_line_before():
    plan = Plan("grid", (Axis("a", ("1", "2")), Axis("b", ("1", "2", "3"))))
    assert plan.before(3) == 0 and plan.share(1, 2, 3) is None and plan.share(0, 3, 4) is None
