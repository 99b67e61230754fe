"""`trajopt solve`: its table, its options, which files it writes and which it leaves alone."""

import json
import re
import sys
from pathlib import Path

import broken
import h5py
import pytest
from command_line import trajopt

from trajopt.problems.catalog import shipped

pytestmark = pytest.mark.usefixtures("folder")


def attributes(path: str) -> dict:
    with h5py.File(path) as file:
        return {**file.attrs, **{f"mesh_{k}": v for k, v in file["mesh/0"].attrs.items()}}


def test_the_table(folder):
    result = trajopt("solve", "cartpole")
    assert (result.exit_code, result.stderr) == (0, "")
    title, *lines = result.stdout.splitlines()
    assert title == "cart-pole swing-up: solved"
    fields = dict(line.split(maxsplit=1) for line in lines)
    assert list(fields) == ["objective", "error", "bounds", "mesh", "iterations", "seconds", "file"]
    assert fields["objective"] == "58.81 +- 0.4  (minimize); agrees with the reference 58.805425"
    assert fields["error"].startswith("relative 1.38e-03; max eta 1.27e-02, in v2 on segment 11, t = 0.8 to 0.88")
    parts = re.fullmatch(r"[\d.]+  \((.*)\)", fields["seconds"])[1]
    names = [part.rsplit(" ", 1)[0] for part in parts.split(", ")]
    parts = ["build", "differentiate", "compile", "assemble", "evaluate", "linear algebra", "error", "elsewhere"]
    assert names == parts
    assert fields["file"] == "cartpole.h5"
    shown = trajopt("show", "cartpole.h5").stdout
    assert shown.startswith(result.stdout)
    assert "phase main: t = 0 to 2 s" in shown


def test_overrides():
    for arguments, key, value in (
        (["--segments", "12"], "mesh_segments", 12),
        (["--method", "trapezoid"], "mesh_method", "trapezoid"),
        (["--tol", "1e-5"], "mesh_tolerance", 1e-5),
        (["--set", "mesh.0.segments=7"], "mesh_segments", 7),
        (["--set", "name=other"], "problem", "other"),
    ):
        assert trajopt("solve", "shot_put", *arguments, "-q", "--force").exit_code == 0
        assert attributes("shot_put.h5")[key] == value
    trajopt("solve", "block_move_min_force", "--set", "time.final=2", "-q")
    assert attributes("block_move_min_force.h5")["objective"] == pytest.approx(12 / 2**3)


def test_short_forms_go_to_the_last_or_to_every_mesh():
    trajopt("solve", "van_der_pol", "--segments", "70", "--method", "trapezoid", "--tol", "1e-6", "-q")
    with h5py.File("van_der_pol.h5") as file:
        meshes = [dict(file[f"mesh/{k}"].attrs) for k in range(len(file["mesh"]))]
    assert len(meshes) > 1
    assert {mesh["method"] for mesh in meshes} == {"trapezoid"}
    assert (meshes[-1]["segments"], meshes[-1]["tolerance"]) == (70, 1e-6)
    assert meshes[0]["segments"] != 70


@pytest.mark.parametrize(
    ("arguments", "sentence"),
    [
        (["--method", "trap"], 'error: --method: there is no method "trap"; write trapezoid\n'),
        (["--segments", "1000000"], "error: --segments: "),
        (["--segments", "0"], "error: --segments: 0 segments are asked for; ask for 1 to 200000"),
        (["--segments", "abc"], "error: --segments: this must be a whole number or a list of widths, not the text"),
        (["--tol", "nan"], "error: --tol: "),
        (["--tol", "x"], 'error: --tol: this must be a number, not the text "x"; write a number such as'),
        (["--refine", "x"], 'error: --refine: this must be a number, not the text "x"; write a number such as'),
        (["--refine", "0"], "error: --refine: the tolerance 0 is out of range; write a number such as 1.0e-6"),
        (["--set", "parameters.dd=1"], "error: --set parameters.dd: parameters has no dd"),
        (["--set", "solver.max_itr=1"], "error: --set solver.max_itr: IPOPT does not take max_itr = 1; did you mean"),
    ],
)
def test_wrong_options_are_named_as_they_were_given(folder, arguments, sentence):
    result = trajopt("solve", "cartpole", "block_move_min_force", *arguments)
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(sentence)
    assert result.stderr.count("\n") == 1 or "parameters" in sentence
    assert not list(folder.iterdir())


@pytest.mark.parametrize("arguments", [["--nonsense"], []])
def test_a_wrong_command_line(arguments):
    result = trajopt("solve", *(["cartpole"] if arguments else []), *arguments)
    assert result.exit_code == 2
    assert "Error: " in result.stderr and "trajopt solve -h" in result.stderr.replace("root", "trajopt")


def test_quiet_and_verbose():
    assert trajopt("solve", "cartpole", "-q").output == ""
    quiet = trajopt("solve", "cartpole", "-q", "--set", "solver.max_iter=1", "-o", "a.h5")
    assert (quiet.exit_code, quiet.stdout) == (1, "") and quiet.stderr.startswith("not solved: ")
    verbose = trajopt("solve", "van_der_pol", "-v")
    assert verbose.exit_code == 0 and verbose.stdout.startswith("Van der Pol oscillator: solved")
    assert re.match(r"mesh 1\n iter  objective +infeasibility  dual +mu\n    0  ", verbose.stderr)
    assert "\nmesh 2\n" in verbose.stderr
    rows = [line for line in verbose.stderr.splitlines() if re.match(r" +\d", line)]
    assert len({len(row) for row in rows}) == 1


def test_names_work_from_any_folder_and_a_file_here_comes_first(folder):
    assert trajopt("solve", "shot_put.yaml", "-q").exit_code == 0
    Path("cartpole").write_text(broken.GOOD)
    assert trajopt("check", "cartpole").stdout == "cartpole: no mistakes; 2 states, 1 control, 1 mesh\n"
    missing = trajopt("solve", "cartpol")
    assert missing.exit_code == 3 and "did you mean cartpole?" in missing.stderr


def test_output_file_and_folder(folder):
    Path("out").mkdir()
    assert trajopt("solve", "shot_put", "-o", "a name.h5", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "-o", "out", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "block_move_min_force", "-o", folder / "out", "-q").exit_code == 0
    names = sorted(str(path.relative_to(folder)) for path in folder.rglob("*.h5"))
    assert names == ["a name.h5", "out/block_move_min_force.h5", "out/shot_put.h5"]


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["shot_put", "-o", "no/a.h5"], 3, "its folder does not exist; create no"),
        (["shot_put", "block_move_min_force", "-o", "a.h5"], 2, "there are 2 problems; write -o a.h5/ for a folder"),
        (["shot_put", "./shot_put.yaml"], 2, "two of the problems would go to this file"),
        (["shot_put", "-o", "/dev/full", "--force"], 3, "it is no ordinary file"),
        (["shot_put", "-o", "/proc/a.h5"], 3, "its folder cannot be written"),
        (["shot_put", "--guess", "no.h5"], 3, "no.h5: there is no such file"),
        (["shot_put", "--guess", "shot_put.yaml"], 2, "shot_put.yaml"),
    ],
)
def test_outputs_that_are_refused_before_any_work(folder, arguments, code, words):
    Path("shot_put.yaml").write_bytes(shipped()["shot_put"].read_bytes())
    result = trajopt("solve", *arguments)
    assert result.exit_code == code and words in result.stderr
    assert [path.name for path in folder.iterdir()] == ["shot_put.yaml"]


def test_an_existing_file_is_replaced_only_by_the_same_problem():
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q").exit_code == 0
    assert trajopt("solve", "shot_put", "-o", "a.h5", "-q", "--segments", "9").exit_code == 0
    before = Path("a.h5").read_bytes()
    refused = trajopt("solve", "block_move_min_force", "-o", "a.h5")
    assert refused.exit_code == 3
    assert "a result of another problem, 'shot put'" in refused.stderr and "--force" in refused.stderr
    assert Path("a.h5").read_bytes() == before
    Path("b.h5").write_text("precious")
    refused = trajopt("solve", "shot_put", "-o", "b.h5")
    assert refused.exit_code == 3 and "no trajopt result" in refused.stderr
    assert Path("b.h5").read_text() == "precious"
    assert trajopt("solve", "block_move_min_force", "-o", "a.h5", "-q", "--force").exit_code == 0
    assert attributes("a.h5")["problem"] == "block move, minimum force"


def test_one_refused_output_stops_all_before_the_first(folder):
    Path("shot_put.h5").write_text("precious")
    assert trajopt("solve", "block_move_min_force", "shot_put").exit_code == 3
    assert [path.name for path in folder.iterdir()] == ["shot_put.h5"]


def test_guess():
    trajopt("solve", "cartpole", "-q")
    cold = json.loads(trajopt("show", "cartpole.h5", "--json").stdout)["iterations"]
    warm = json.loads(trajopt("solve", "cartpole", "--guess", "cartpole.h5", "--json").stdout)["iterations"]
    assert warm < cold
    other = trajopt("solve", "block_move_min_force", "--guess", "cartpole.h5")
    assert other.exit_code == 2 and "none of the states" in other.stderr


def test_the_result_remembers_its_command(monkeypatch):
    monkeypatch.setattr(sys, "argv", ["/usr/bin/trajopt", "solve", "shot_put", "-o", "my file.h5"])
    trajopt("solve", "shot_put", "-o", "my file.h5", "-q")
    assert attributes("my file.h5")["command"] == "trajopt solve shot_put -o 'my file.h5'"


def test_names_with_line_breaks_stay_on_one_line():
    Path("odd.yaml").write_text(broken.GOOD.replace("name: a good file", 'name: "two\\nlines"'))
    assert trajopt("solve", "odd.yaml").stdout.splitlines()[0] == "two lines: solved"


@pytest.mark.parametrize(
    ("problem", "says"),
    [
        ("pendulum", "optimum     no error bar: finite differences have no costates"),
        ("block_move_min_force", "objective   12.00000000 +- 2e-10  (minimize)"),
        ("van_der_pol", "objective   2.86725 +- 9e-5  (minimize)"),
        ("van_der_pol", "optimum     nearer to 2.86726: the objective with the estimate of its error added"),
    ],
)
def test_the_error_bar_of_the_objective(problem, says):
    assert f"\n{says}" in trajopt("solve", problem).stdout
    summary = json.loads(trajopt("show", f"{problem}.h5", "--json").stdout)
    assert (summary["objective_error"] is None) == bool(summary["objective_error_missing"])


def test_a_failed_solve_has_no_error_bar():
    summary = json.loads(trajopt("solve", "cartpole", "--set", "solver.max_iter=2", "--json").stdout)
    assert summary["objective_error"] is None and summary["objective_error_missing"] == "the point is not optimal"
    assert [mesh["objective_error"] for mesh in summary["meshes"]] == [None]
    shown = trajopt("show", "cartpole.h5").stdout
    assert "\noptimum     no error bar: the point is not optimal\n" in shown and " +- " not in shown.split("phase")[0]


def test_every_mesh_of_the_history_has_its_error_bar():
    """In --json and HDF5, and in the table of `show`, whose column is empty where there is none."""
    meshes = json.loads(trajopt("solve", "cartpole", "--refine", "1e-5", "--json").stdout)["meshes"]
    bars = [mesh["objective_error"] for mesh in meshes]
    assert len(meshes) > 1 and bars[-1] < bars[0]
    for k, mesh in enumerate(meshes):
        assert abs(mesh["objective"] - 58.80766746) <= mesh["objective_error"]
        assert abs(mesh["objective"] - mesh["objective_corrected"]) <= mesh["objective_error"]
        with h5py.File("cartpole.h5") as file:
            stored = file[f"mesh/{k}"].attrs
            assert (stored["objective_error"], stored["objective_corrected"]) == (bars[k], mesh["objective_corrected"])
    table = trajopt("show", "cartpole.h5").stdout.splitlines()[-len(bars) - 1 :]
    assert [row.split()[5] for row in table[1:]] == [f"{bar:.1e}" for bar in bars]
    assert table[0].split()[:5] == ["method", "segments", "status", "objective", "+-"]


def test_results_of_older_versions_have_no_error_bar():
    assert trajopt("solve", "van_der_pol", "-q").exit_code == 0
    with h5py.File("van_der_pol.h5", "a") as file:
        del file["phase/main/error/objective"]
        for group in (file, *file["mesh"].values()):
            for name in [name for name in group.attrs if name.startswith("objective_")]:
                del group.attrs[name]
    shown = trajopt("show", "van_der_pol.h5")
    assert "\noptimum     no error bar: an older version wrote this result\n" in shown.stdout
    meshes = json.loads(trajopt("show", "van_der_pol.h5", "--json").stdout)["meshes"]
    assert [mesh["objective_corrected"] for mesh in meshes] == [None, None]
    assert trajopt("plot", "van_der_pol.h5", "--error", "--mesh").exit_code == 0
    assert trajopt("verify", "van_der_pol.h5").exit_code == 0


def test_a_solve_may_draw_its_result(folder):
    result = trajopt("solve", "shot_put", "--plot", "-o", "a.h5")
    assert result.exit_code == 0
    assert "picture: a.png" in result.stderr
    assert (folder / "a.png").read_bytes().startswith(b"\x89PNG")


FITTED = """\
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: -k*x, initial: 2}}
optimize: {k: {lower: 0, upper: 0.3, unit: 1/s}}
measurements: {run: {data: {time: [1, 2], x: [0.9, 0.3]}, deviations: 0.1}}
mesh: [{method: radau, segments: 2}]
"""


@pytest.mark.parametrize(
    ("upper", "says", "fit"),
    [
        ("0.3", "k = 0.3 1/s, on a bound: taken as known", "2 measurements, 0 unknowns"),
        ("3", r"k = 0\.8\d* \+- 0\.0\d* 1/s", "2 measurements, 1 unknown;"),
    ],
)
def test_an_estimate_on_its_bound_is_told_as_that(upper, says, fit):
    Path("fit.yaml").write_text(FITTED.replace("upper: 0.3", f"upper: {upper}"))
    lines = trajopt("solve", "fit.yaml").stdout.splitlines()
    (estimate,) = (own.split(maxsplit=1)[1] for own in lines if own.startswith("estimate"))
    (told,) = (own.split(maxsplit=1)[1] for own in lines if own.startswith("fit  "))
    assert re.fullmatch(says, estimate) and told.startswith(fit)
