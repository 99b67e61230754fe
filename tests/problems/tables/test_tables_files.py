"""Tables of data in files: CSV files beside a problem, what a result keeps of them, overrides, sweeps."""

import json
import re

import broken
import command_line
import numpy as np
import pytest
from repository import ROOT

import trajopt
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.results.file.reload import stored_spec

PROBLEM = """\
trajopt: 1
tables:
  drag: {file: data/drag.csv, outside: extrapolate, unit: N}
time: {initial: 0, final: 1}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: "u - drag(v, x)", initial: 0, final: 0}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 10}]
"""
ROWS = [(v, x, 0.2 * v**2 + 0.1 * x) for v in (0, 0.5, 1, 2) for x in (0, 0.4, 1)]


def folder_with(tmp_path, rows=ROWS, text=PROBLEM):
    """The problem and its CSV file, in a folder."""
    (tmp_path / "data").mkdir(parents=True)
    lines = "".join(f"{v},{x},{f}\n" for v, x, f in rows)
    (tmp_path / "data" / "drag.csv").write_text(f"# a comment\nv, x, F\n\n{lines}", encoding="utf-8-sig")
    (tmp_path / "problem.yaml").write_text(text)
    return tmp_path / "problem.yaml"


def test_the_file_with_tables_is_good():
    assert not load_text(broken.WITH_TABLES, "good.yaml", (), broken.METHODS).warnings


@pytest.mark.parametrize("name", broken.BAD_CSV)
def test_a_broken_csv_file(name, tmp_path):
    entry, content, says = broken.BAD_CSV[name]
    inside = tmp_path / "inside"
    (inside / "folder").mkdir(parents=True)
    (inside / "data.csv").write_bytes(content)
    for file in (tmp_path / "data.csv", tmp_path / "outside.csv"):
        file.write_text(broken.CSV)
    (inside / "link.csv").symlink_to(tmp_path / "outside.csv")
    path = inside / "problem.yaml"
    path.write_text(PROBLEM.replace("{file: data/drag.csv, outside: extrapolate, unit: N}", entry))
    with pytest.raises(SpecError) as error:
        load(path, (), broken.METHODS)
    sentences = [str(mistake) for mistake in error.value.mistakes]
    assert any(s.startswith(f"{path}:3: tables.drag") and says in s for s in sentences), "\n".join(sentences)
    assert all(len(s) < 700 and "\n" not in s for s in sentences)
    assert len(sentences) == 1, "what looks a mistaken table up is no further mistake"


def test_all_mistakes_of_all_tables_and_of_the_rest_at_once(tmp_path):
    path = folder_with(tmp_path, [(0, 0, "a"), (0, 1, "b")], PROBLEM.replace("final: 1}\n  v", "final: w}\n  v"))
    text = path.read_text().replace("time: {", "  lift: {points: {v: [1, 0]}, values: [1, 2]}\ntime: {")
    path.write_text(text)
    with pytest.raises(SpecError) as error:
        load(path, (), broken.METHODS)
    places = [mistake.where.removeprefix(f"{path}:") for mistake in error.value.mistakes]
    assert places == ["3: tables.drag.file"] * 2 + ["4: tables.lift.points.v", "7: states.x.final"]
    assert "line 4, column F" in error.value.mistakes[0].what and "line 5, column F" in error.value.mistakes[1].what


def test_the_rows_may_stand_in_any_order(tmp_path):
    shuffled = [ROWS[i] for i in np.random.default_rng(3).permutation(len(ROWS))]
    first, second = (load(folder_with(tmp_path / n, rows)) for n, rows in (("a", ROWS), ("b", shuffled)))
    assert first.tables == second.tables
    entry = first.tables["drag"]
    assert entry.points == {"v": [0, 0.5, 1, 2], "x": [0, 0.4, 1]} and np.shape(entry.values) == (4, 3)
    assert entry.values[3][1] == pytest.approx(0.84) and entry.source == "data/drag.csv" and entry.file is None


def test_columns_by_name(tmp_path):
    path = folder_with(tmp_path, text=PROBLEM.replace("drag.csv,", "drag.csv, arguments: [x, v], value: F,"))
    entry = load(path).tables["drag"]
    assert list(entry.points) == ["x", "v"] and entry.values[1][3] == pytest.approx(0.84)


CURVES = "h, rho, T\n0, 1.2, 288\n0.5, 1.1, 281\n1e0, 1, 275\n"


@pytest.mark.parametrize(
    ("entry", "column"),
    [("rho: {file: curves.csv}", 1), ("T: {file: curves.csv}", 2), ("a: {file: curves.csv, value: T}", 2),
     ("rho: {file: curves.csv, value: T}", 2), ("a: {file: curves.csv, arguments: [h], value: rho}", 1)],
)  # fmt: skip
def test_several_curves_over_one_column(entry, column, tmp_path):
    (tmp_path / "curves.csv").write_text(CURVES)
    name = entry.partition(":")[0]
    text = PROBLEM.replace("drag: {file: data/drag.csv, outside: extrapolate, unit: N}", entry)
    (tmp_path / "problem.yaml").write_text(text.replace("drag(v, x)", f"{name}(x)"))
    table = load(tmp_path / "problem.yaml").tables[name]
    assert table.points == {"h": [0, 0.5, 1]} and table.values == [[1.2, 1.1, 1], [288, 281, 275]][column - 1]


def test_a_text_has_no_csv_file():
    with pytest.raises(SpecError, match="a text has no folder that the file could be in"):
        trajopt.load(PROBLEM)


def test_a_result_needs_no_csv_file(tmp_path):
    """It is verified, read, and starts another solve when the CSV file is gone."""
    path, result = folder_with(tmp_path), tmp_path / "out.h5"
    assert command_line.trajopt("solve", path, "-o", result).exit_code == 0
    entry = load(path).tables["drag"]
    (tmp_path / "data" / "drag.csv").unlink()
    assert stored_spec(result).tables["drag"] == entry
    verified = command_line.trajopt("verify", result)
    assert verified.exit_code == 0, verified.output
    assert trajopt.read(result)["v"](0.5) > 1
    gone = command_line.trajopt("check", path)
    assert gone.exit_code == 2 and "there is no file data/drag.csv" in gone.stderr and "problem.yaml:3" in gone.stderr


def test_overrides_of_a_table(tmp_path):
    path = folder_with(tmp_path)
    assert load(path, ["tables.drag.outside=hold"]).tables["drag"].outside == "hold"
    inline = path.read_text().replace(
        "{file: data/drag.csv", "{points: {v: [0, 1], x: [0, 1]}, values: [[0, 1], [1, 2]]"
    )
    path.write_text(inline)
    assert load(path, ["tables.drag.values=[[0, 1], [1, 3]]"]).tables["drag"].values[1][1] == 3
    with pytest.raises(SpecError, match=r"--set tables.drag.values: the values are 3, the points of v and x 2 x 2"):
        load(path, ["tables.drag.values=[0, 1, 2]"])
    with pytest.raises(SpecError, match="did you mean drag"):
        load(path, ["tables.drga.values=[0, 1, 2]"])


def test_a_sweep_of_workers_looks_tables_up(tmp_path):
    path = folder_with(
        tmp_path,
        text=PROBLEM.replace("states:", "parameters: {d: 1}\nstates:").replace("final: 1}\n  v", "final: d}\n  v"),
    )
    out = tmp_path / "sweep"
    ran = command_line.trajopt("sweep", path, "--over", "parameters.d=0.8:1:2", "-o", out, "--jobs", "2", "--json")
    assert ran.exit_code == 0, ran.stderr
    alone = command_line.trajopt("solve", path, "-o", tmp_path / "a.h5", "--json")
    index = (out / "index.csv").read_text().splitlines()
    column = index[0].split(",").index("objective")
    assert float(index[2].split(",")[column]) == pytest.approx(json.loads(alone.stdout)["objective"], rel=1e-8)


def test_the_example_of_the_docs(tmp_path):
    docs = (ROOT / "docs" / "problem_file.md").read_text(encoding="utf-8")
    example = re.search(r"```yaml\n(tables:.*?)```", docs, re.DOTALL)[1]
    head = "trajopt: 1\nparameters: {a: 300, m: 1}\ntime: {initial: 0, final: 1}\ncontrols: {u: {}}\n"
    path = tmp_path / "docs.yaml"
    path.write_text(head + example + "  h: {rate: u}\nobjective: {minimize: {integral: u**2}}\n")
    (tmp_path / "thrust.csv").write_text("h,thrust,M\n0,1,0\n1,2,0\n0,3,1\n1,4,1\n")
    spec = load(path, (), broken.METHODS)
    assert [w.what for w in spec.warnings] == ["the table lift is used nowhere"]
    assert spec.tables["thrust"].values == [[1, 2], [3, 4]] and list(spec.tables["thrust"].points) == ["M", "h"]
