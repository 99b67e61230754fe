"""The problem file of a result, and results of one problem in other phases."""

import pytest
from command_line import solved_once, trajopt

import trajopt as door
from trajopt.problems.catalog import shipped

CSV = """\
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: -k*x + wind(t), initial: 1}}
optimize: {k: {lower: 0, guess: 0.5}}
tables: {wind: {file: wind.csv}}
objective: {minimize: {terminal: "(x[final] - 0.5)**2"}}
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("results")
    plain = solved_once(folder / "plain.h5", "double_integrator_min_time")
    polished = solved_once(folder / "polished.h5", "double_integrator_min_time", "--polish")
    farther = solved_once(folder / "farther.h5", "double_integrator_min_time", "--set", "parameters.d=4")
    return plain, polished, farther


def exported(result, target) -> str:
    run = trajopt("export", result, target)
    assert run.exit_code == 0 and run.stdout.strip() == str(target)
    return target.read_text()


def test_a_file_comes_out_as_it_was(results, tmp_path):
    assert exported(results[0], tmp_path / "out.yaml") == shipped()["double_integrator_min_time"].read_text()


@pytest.mark.parametrize(("which", "objective"), [(1, 2.0), (2, 4.0)])
def test_what_was_changed_is_in_it(results, which, objective, tmp_path):
    text = exported(results[which], tmp_path / "out.yaml")
    assert ("arc1" in text) == (which == 1) and ("with parameters.d=4" in text) == (which == 2)
    assert door.solve(door.load(tmp_path / "out.yaml")).objective == pytest.approx(objective, abs=1e-7)


def test_data_of_a_csv_file_are_in_it(tmp_path):
    (tmp_path / "wind.csv").write_text("t,wind\n0,0.1\n1,0.2\n2,0.1\n3,0.1\n")
    (tmp_path / "csv.yaml").write_text(CSV)
    result = solved_once(tmp_path / "csv.h5", tmp_path / "csv.yaml")
    (tmp_path / "away").mkdir()
    exported(result, tmp_path / "away" / "out.yaml")  # where there is no wind.csv
    again = door.load(tmp_path / "away" / "out.yaml")
    assert door.solve(again).solved and not again.spec.warnings


MEASURED = """\
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: -k*x, initial: 1, lower: -1}, y: {rate: x}}
optimize: {k: {guess: 0.5}}
measurements: {run: {file: run.csv}}
"""


def test_what_is_written_anew_says_the_same_and_is_checked_without_a_word(tmp_path):
    (tmp_path / "run.csv").write_text("time,x,y\n1,0.6,\n2,0.4,0.7\n")
    (tmp_path / "measured.yaml").write_text(MEASURED)
    result = solved_once(tmp_path / "measured.h5", tmp_path / "measured.yaml")
    text = exported(result, tmp_path / "out.yaml")
    run = trajopt("check", tmp_path / "out.yaml")
    assert run.exit_code == 0 and "warning" not in run.output, run.output
    first, again = (door.load(path).spec.model_dump() for path in (tmp_path / "measured.yaml", tmp_path / "out.yaml"))
    for own in (first, again):
        own["measurements"] = {}
    assert first == again and "- null" in text  # what was not measured


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("cartpole", "out.yaml"), "write trajopt init out.yaml --from cartpole"),
        (("gone.h5", "out.yaml"), "there is no such file"),
        (("PLAIN", "out.yaml", "--set", "parameters.d=2"), "a problem file is written as it was solved"),
        (("PLAIN", "out.nl"), "trajopt export"),
    ],
)
def test_what_is_refused(results, folder, arguments, words):
    run = trajopt("export", *(str(results[0]) if own == "PLAIN" else own for own in arguments))
    assert run.exit_code in (2, 3) and words in run.output and not list(folder.iterdir())


def test_a_polished_result_beside_the_first(results):
    run = trajopt("compare", *results[:2])
    assert run.exit_code == 0 and "state difference" in run.output


def test_a_result_by_the_name_of_its_problem(folder, results):
    (folder / "move.h5").write_bytes(results[0].read_bytes())
    run = trajopt("show", "move")
    assert run.exit_code == 3 and "did you mean move.h5" in run.output
