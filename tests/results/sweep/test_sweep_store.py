"""The folder of a sweep: what is read of it, what is not, and who may write to it. Cases are solved in this process."""

import json
import zipfile
from pathlib import Path

import h5py
import numpy as np
import pytest

from trajopt.problems.catalog import shipped
from trajopt.results.file.summary import summarize
from trajopt.results.sweep.axes import parse_axis
from trajopt.results.sweep.case import INTERRUPTED, WORKER_DIED, Task, solve_case, watch
from trajopt.results.sweep.plan import grid, sampled

from .sweeping import TEXT, Inline, swept, table

pytestmark = pytest.mark.usefixtures("folder")


def test_what_is_kept(folder):
    records, tasks = swept(full=True)
    assert sorted(tasks) == list(records) == list(range(6))
    assert all(record["solved"] for record in records.values())
    assert records[3]["objective"] == pytest.approx(12 * 2**2)
    assert records[3]["final"] == pytest.approx({"x": 2, "v": 0}) and records[3]["final_time"] == 1
    assert len({record["key"] for record in records.values()}) == 6
    for record in records.values():
        summary = summarize(Path("s/results") / f"{record['key']}.h5")
        assert summary["objective"] == record["objective"] and summary["solved"]
    row = table()[5]
    assert (row["case"], row["parameters.l"], row["mesh.0.method"], row["status"]) == (
        "5",
        "3",
        "hermite-simpson",
        "solved",
    )
    assert float(row["objective"]) == records[5]["objective"] and float(row["final_x"]) == pytest.approx(3)


def test_a_finished_sweep_has_nothing_to_do_and_full_results_can_be_added():
    swept()
    before = table()
    assert swept()[1] == [] and table() == before
    assert len(swept(full=True)[1]) == 6 and table() == before
    assert swept(full=True)[1] == []


def test_the_arrays_of_a_grid():
    swept()
    with h5py.File("s/sweep.h5") as file:
        objective = file["objective"]
        assert objective.shape == (3, 2)
        assert [dim[0].name for dim in objective.dims] == ["/l", "/method"]
        assert file["l"][:].tolist() == [1, 2, 3] and file["l"].attrs["units"] == "m"
        assert file["method"].asstr()[:].tolist() == ["trapezoid", "hermite-simpson"]
        assert objective[:, 1] == pytest.approx([12, 48, 108])
        assert file["final_x"][:, 0] == pytest.approx([1, 2, 3]) and file["final_x"].attrs["units"] == "m"
        assert file["solved"][:].all() and (file["iterations"][:] > 0).all()
        assert set(file["status"].asstr()[:].ravel()) == {"solved"}


def test_xarray_opens_it():
    xarray = pytest.importorskip("xarray")
    pytest.importorskip("h5netcdf")
    swept()
    with xarray.open_dataset("s/sweep.h5", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"l": 3, "method": 2}
        assert float(data["objective"].sel({"l": 2, "method": "hermite-simpson"})) == pytest.approx(48)
    swept("t", sampled([parse_axis("parameters.l=1:3", True), parse_axis("parameters.T=1:2", True)], 3, 0))
    with xarray.open_dataset("t/sweep.h5", engine="h5netcdf") as data:
        assert dict(data.sizes) == {"case": 3} and {"case", "l", "T"} == set(data.coords)
        np.testing.assert_allclose(data["objective"], 12 * data["l"] ** 2 / data["T"] ** 3, rtol=1e-3)


def test_an_interrupted_sweep_is_written_and_goes_on_where_it_ended():
    records, first = swept(stop_after=2)
    assert 2 <= len(records) < 6
    with h5py.File("s/sweep.h5") as file:
        assert np.isnan(file["objective"][2, 1]) and file["iterations"][2, 1] == -1
        assert file["status"].asstr()[2, 1] == "missing"
    _, second = swept()
    assert sorted({*first, *second}) == list(range(6)) and not set(records) & set(second)
    swept("whole")
    assert table() == table("whole")


def test_broken_and_foreign_lines_of_the_index_are_ignored():
    swept()
    whole = table()
    lines = Path("s/index.jsonl").read_bytes().splitlines(keepends=True)
    other = json.dumps({**json.loads(lines[0]), "case": 99}).encode() + b"\n"
    moved = json.dumps({**json.loads(lines[0]), "case": 5}).encode() + b"\n"
    Path("s/index.jsonl").write_bytes(b"\xff{\n3\n" + other + moved + b"".join(lines[:3]) + lines[3][:-20])
    for path in Path("s/cases").iterdir():
        path.unlink() if path.stem in lines[3].decode() else None
    _, tasks = swept()
    assert tasks == [json.loads(lines[3])["case"]]  # the others had been written, though their lines have gone
    assert table() == whole
    assert Path("s/index.jsonl").read_bytes().splitlines(keepends=True)[7] == lines[3][:-20] + b"\n"
    assert swept()[1] == []


def test_a_case_whose_line_is_missing_is_found_by_its_file():
    swept()
    whole = table()
    Path("s/index.jsonl").write_text("")
    assert swept()[1] == [] and table() == whole


@pytest.mark.parametrize("damage", ["cut", "flipped", "gone", "empty"])
def test_a_broken_small_result_is_not_read_as_good(damage):
    records, _ = swept()
    whole, path = table(), Path("s/cases") / f"{records[4]['key']}.npz"
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as parts:
        start = parts.getinfo("record.npy").header_offset
    content[start + 300] ^= 1
    if damage == "gone":
        path.unlink()
    else:
        path.write_bytes({"cut": content[: len(content) // 2], "flipped": content, "empty": b""}[damage])
    assert swept()[1] == [4] and table() == whole


def test_half_written_files_are_removed():
    swept()
    for name in ("cases/{}.npz", "results/{}.h5", "{}.csv", "{}.h5", "{}.json"):
        Path("s", name.format(".trajopt-another_machine-7-x1")).write_text("half")
    swept()
    assert not [path for path in Path("s").rglob(".*") if path.name not in (".lock", ".setup")]


def test_a_failed_case_is_solved_again():
    text = TEXT.replace("upper: 20", "upper: 30").replace("lower: -20", "lower: -30")
    plan = grid([parse_axis("parameters.l=1,9")])
    records, _ = swept(plan=plan, text=text)
    assert [record["solved"] for record in records.values()] == [True, False]
    assert records[1]["status"] != "solved" and records[1]["objective"] is not None and records[1]["message"]
    assert swept(plan=plan, text=text)[1] == [1]


def test_a_mistake_or_a_bug_in_a_case_is_its_record():
    plan = grid([parse_axis("parameters.T=1,-1")])
    records, _ = swept(plan=plan)
    assert (records[1]["status"], records[1]["key"]) == ("mistake", "")
    assert records[1]["message"].startswith("--over parameters.T=-1: push.yaml:5: time")
    assert len(list(Path("s/cases").iterdir())) == 1


def test_a_killed_worker_costs_its_case_one_retry():
    records, tasks = swept(engine=Inline({2: 1, 4: 5}))
    assert (tasks.count(2), tasks.count(4), len(tasks)) == (2, 2, 8)
    assert [n for n, record in records.items() if not record["solved"]] == [4]
    assert records[4]["status"] == WORKER_DIED and records[4]["message"].startswith("its worker died 2 times")
    assert swept()[1] == [4]
    swept("whole")
    assert table() == table("whole")


def test_a_chain_goes_from_neighbour_to_neighbour_and_is_the_same_after_an_interruption():
    records, _ = swept(chain=True)
    assert [record["start"] for record in records.values()] == [
        "guess",
        "case 0",
        "case 0",
        "case 2",
        "case 2",
        "case 4",
    ]
    swept("t", chain=True, stop_after=3)
    swept("t", chain=True, engine=Inline())
    assert table() == table("t")


def test_a_chain_goes_around_a_case_that_failed():
    plan = grid([parse_axis("parameters.l=1,9,2")])
    records, _ = swept(plan=plan, chain=True)
    assert [record["start"] for record in records.values()] == ["guess", "guess", "case 0"]
    assert [record["solved"] for record in records.values()] == [True, False, True]


def test_shards_solve_it_together():
    swept("whole")
    assert swept(shard=(2, 2))[1] == [1, 3, 5]
    assert [row["case"] for row in table()] == ["1", "3", "5"]
    assert swept(shard=(1, 2))[1] == [0, 2, 4]
    assert table() == table("whole")
    assert swept(shard=(1, 2))[1] == [] and swept()[1] == []
    assert sorted(path.name for path in Path("s").glob("index*.jsonl")) == [
        "index-1-of-2.jsonl", "index-2-of-2.jsonl", "index.jsonl"
    ]  # fmt: skip


def test_a_stopped_solve_is_no_result():
    class Flag:
        value = 1

    watch(Flag())
    try:
        records, tasks = swept(plan=grid([parse_axis("parameters.l=1,2")]), stop_after=0)
        assert (records, tasks) == ({}, [])
        answer = solve_case(Task(0, {"parameters.u_max": "9"}, shipped()["cartpole"].read_text(), "c.yaml", ()))
        assert answer.record["status"] == INTERRUPTED
    finally:
        watch(None)
