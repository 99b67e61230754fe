"""`trajopt table`: one row a time, at the points, on the dense grid, or on an even one."""

import csv
import io
import sys

import h5py
import numpy as np
import pytest
from command_line import solved_once, trajopt

pytestmark = pytest.mark.usefixtures("folder")


@pytest.fixture(scope="module")
def swing(tmp_path_factory):
    return solved_once(tmp_path_factory.mktemp("table") / "swing.h5", "cartpole")


@pytest.fixture(scope="module")
def launch(tmp_path_factory):
    text = """trajopt: 1
name: two phases
time: {initial: 0, final: 2}
states:
  x: {unit: m, rate: v, initial: 0}
  v: {unit: m/s, rate: u, initial: 0}
controls: {u: {unit: m/s**2, lower: -1, upper: 1}}
phases:
  push: {time: {final: 1}}
  coast: {expressions: {energy: {value: v**2/2, unit: J}}, states: {x: {final: 1}, v: {final: 0}}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 4}]
"""
    folder = tmp_path_factory.mktemp("launch")
    (folder / "two.yaml").write_text(text)
    return solved_once(folder / "two.h5", folder / "two.yaml")


def rows_of(text: str) -> dict[str, list[str]]:
    head, *rows = csv.reader(io.StringIO(text))
    return dict(zip(head, map(list, zip(*rows, strict=True)), strict=True))


def test_the_points(swing, folder):
    done = trajopt("table", swing)
    assert (done.exit_code, done.stdout) == (0, "swing.csv\n")
    columns = rows_of((folder / "swing.csv").read_text())
    with h5py.File(swing) as file:
        points = file["phase/main/points"]
        assert list(columns)[:6] == ["time", "q1", "q2", "v1", "v2", "u"]
        assert np.array_equal(np.array(columns["q2"], float), points["state/q2"][:])
        assert np.array_equal(np.array(columns["costate_v1"], float), points["costate/v1"][:])
    again = trajopt("table", swing)
    assert again.exit_code == 3 and "--force" in again.stderr
    assert trajopt("table", swing, "--force").exit_code == 0


def test_the_dense_grid(swing):
    columns = rows_of(trajopt("table", swing, "--dense", "-o", "-").stdout)
    with h5py.File(swing) as file:
        assert np.array_equal(np.array(columns["u"], float), file["phase/main/dense/control/u"][:])


def test_an_even_grid_is_of_the_methods_own_interpolant(swing):
    import trajopt as package
    from trajopt.results.python.solution import SolutionView  # noqa: F401 - what `read` gives

    columns = {
        n: np.array(v, float) for n, v in rows_of(trajopt("table", swing, "--every", "0.03", "-o", "-").stdout).items()
    }
    assert np.allclose(columns["time"], [*np.arange(67) * 0.03, 2.0], atol=1e-12)
    solution = package.read(swing)
    for name in ("q2", "u"):
        assert np.allclose(columns[name], solution[name](columns["time"]), atol=1e-12)


def test_an_even_grid_that_fits_ends_once(swing):
    columns = rows_of(trajopt("table", swing, "--every", "0.1", "-o", "-").stdout)
    assert len(columns["time"]) == 21 and columns["time"][-1] == "2.0"


@pytest.mark.parametrize(
    ("step", "times"),
    [
        ("0.3", "0.0 0.3 0.6 0.9 1.2 1.5 1.8 2.0"),
        ("0.7", "0.0 0.7 1.4 2.0"),
        ("0.35", "0.0 0.35 0.7 1.05 1.4 1.75 2.0"),
        ("1e300", "0.0 2.0"),
    ],
)
def test_the_times_are_as_round_as_the_step(swing, step, times):
    assert rows_of(trajopt("table", swing, "--every", step, "-o", "-").stdout)["time"] == times.split()


def test_phases_and_units(launch):
    columns = rows_of(trajopt("table", launch, "--units", "-o", "-").stdout)
    assert list(columns)[:5] == ["phase", "time [s]", "x [m]", "v [m/s]", "u [m/s**2]"]
    assert set(columns["phase"]) == {"push", "coast"}
    energy = dict(zip(columns["phase"], columns["energy [J]"], strict=True))
    assert energy["push"] == "" and energy["coast"] != ""


def test_several_results(swing, launch):
    refused = trajopt("table", swing, launch)
    assert refused.exit_code == 2 and "-o all.csv" in refused.stderr
    assert trajopt("table", swing, launch, "-o", "all.csv").exit_code == 0
    columns = rows_of(trajopt("table", swing, launch, "-o", "-").stdout)
    assert list(columns)[:3] == ["file", "phase", "time"] and set(columns["file"]) == {str(swing), str(launch)}


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--every", "0"), "no positive number"),
        (("--every", "1e-9"), "choose a longer one"),
        (("--every", "0.1", "--dense"), "leave out one of the two"),
        (("-o", "a.xlsx"), "end the name with .csv or .parquet"),
        (("-o", "a"), "end the name with .csv or .parquet"),
    ],
)
def test_mistakes(swing, arguments, words):
    done = trajopt("table", swing, *arguments)
    assert (done.exit_code, done.stdout) == (2, "") and words in done.stderr


def test_parquet_holds_what_the_csv_holds(launch, folder):
    """Of two phases, so with texts, and with places where a curve is not."""
    frames = pytest.importorskip("pandas"), pytest.importorskip("pyarrow")
    assert trajopt("table", launch, "--every", "0.1", "-o", "a.parquet").exit_code == 0
    frame = frames[0].read_parquet("a.parquet")
    columns = rows_of(trajopt("table", launch, "--every", "0.1", "-o", "-").stdout)
    assert list(frame.columns) == list(columns)
    assert list(frame["phase"]) == columns["phase"]
    for name in ("time", "x", "u", "energy"):
        assert np.array_equal(frame[name], [float(v or "nan") for v in columns[name]], equal_nan=True)
    assert frame.attrs["units"] == {"time": "s", "x": "m", "v": "m/s", "u": "m/s**2", "energy": "J"}


@pytest.mark.parametrize("lacking", ["pandas", "pyarrow"])
def test_parquet_without_its_packages(swing, folder, monkeypatch, lacking):
    monkeypatch.setitem(sys.modules, lacking, None)  # as the import system has it for what is not there
    done = trajopt("table", swing, "-o", "a.parquet")
    assert done.exit_code == 2 and "pip install pandas pyarrow" in done.stderr
    assert not (folder / "a.parquet").exists()


def test_a_group_of_the_file_is_a_frame_of_one_row_a_time(swing):
    """xarray inherits coordinates: those of other lengths must not be there."""
    import xarray

    with xarray.open_datatree(swing) as tree:
        for where, rows in (("points", 51), ("dense", None)):
            for kind in ("", "/state", "/control", "/costate"):
                frame = tree[f"phase/main/{where}{kind}"].to_dataset().to_dataframe()
                assert len(frame) == (rows or len(tree[f"phase/main/{where}/time"]))
        assert tree["phase/main"]["knots"].shape == (26,)


@pytest.mark.parametrize("where", ["tabs/", "of/it/"])
def test_a_folder_is_made(swing, folder, where):
    done = trajopt("table", swing, "-o", where)
    assert (done.exit_code, done.stdout) == (0, f"{where}{swing.stem}.csv\n")
    assert (folder / where / f"{swing.stem}.csv").exists()


def test_an_even_grid_has_states_at_earlier_times(folder):
    solved_once(folder / "delayed.h5", "delayed_regulator")
    columns = rows_of(trajopt("table", folder / "delayed.h5", "--every", "0.5", "-o", "-").stdout)
    whole = rows_of(trajopt("table", folder / "delayed.h5", "--dense", "-o", "-").stdout)
    for name in ("x", "u"):
        dense = np.interp(np.array(columns["time"], float), *(np.array(whole[n], float) for n in ("time", name)))
        assert np.allclose(np.array(columns[name], float), dense, atol=1e-3)
