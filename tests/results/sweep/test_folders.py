"""The folder of a sweep: whose it is, and where it cannot be."""

import os
from pathlib import Path

import pytest
from command_line import trajopt

from trajopt.problems.errors import FileError, SpecError
from trajopt.results.sweep import store as store_module
from trajopt.results.sweep.axes import parse_axis
from trajopt.results.sweep.plan import grid
from trajopt.results.sweep.store import Store, about

from .sweeping import PLAN, TEXT, swept, table

pytestmark = pytest.mark.usefixtures("folder")


OTHERS = {
    "problem file": {"text": TEXT + "\n# a comment\n"},
    "axes": {"plan": grid([parse_axis("parameters.l=1,2")])},
    "chaining": {"chain": True},
}


@pytest.mark.parametrize("what", OTHERS)
def test_a_folder_has_one_sweep(what):
    swept(stop_after=1)
    before = Path("s/index.jsonl").read_bytes()
    with pytest.raises(SpecError) as error:
        swept(**OTHERS[what])
    assert str(error.value) == (
        f"s: the folder holds another sweep ({what} differ); choose another folder with -o, or start anew with --force"
    )
    assert Path("s/index.jsonl").read_bytes() == before
    Path("s/mine.txt").write_text("precious")
    records, _ = swept(**OTHERS[what], force=True)
    assert all(record["solved"] for record in records.values())
    assert Path("s/mine.txt").read_text() == "precious"


def test_two_sweeps_at_once_in_one_folder():
    store = Store(Path("s"), PLAN)
    store.open(about(PLAN, TEXT, "push.yaml", [], False))
    for shard in (None, (1, 2)):
        with pytest.raises(SpecError, match=r"^s: another trajopt sweep is at work in this folder; wait until"):
            swept(shard=shard)
    store.close()
    shards = [Store(Path("s"), PLAN, (i, 2)) for i in (1, 2)]
    for shard in shards:
        shard.open(about(PLAN, TEXT, "push.yaml", [], False))
    with pytest.raises(SpecError, match="at work"):
        swept(shard=(2, 2))
    with pytest.raises(SpecError, match="at work"):
        swept()
    for shard in shards:
        shard.close()


def test_what_is_no_folder_of_a_sweep():
    Path("other").mkdir()
    Path("other/a.txt").write_text("precious")
    Path("file").write_text("precious")
    Path("half").mkdir()
    Path("half/sweep.json").write_text("{")
    sentences = {
        "other": "other: the folder is not empty and holds no sweep; choose another with -o",
        "file": "file: it is no folder; choose another with -o",
        "half": "half/sweep.json: it cannot be read; choose another folder with -o, or start anew with --force",
    }
    for name, sentence in sentences.items():
        result = trajopt("sweep", "block_move_min_force", "--over", "time.final=1,2", "-o", name)
        assert (result.exit_code, result.stdout, result.stderr) == (2, "", f"error: {sentence}\n")
    assert Path("other/a.txt").read_text() == Path("file").read_text() == "precious"


def test_folders_that_cannot_be_written(folder):
    for name, words in (("no/s", "the folder around it does not exist"), ("/proc/s", "it cannot be made")):
        result = trajopt("sweep", "block_move_min_force", "--over", "time.final=1,2", "-o", name)
        assert result.exit_code == 3 and result.stderr.startswith(f"error: {name}: {words}")
    if os.geteuid():
        (folder / "s").mkdir(mode=0o500)
        with pytest.raises(FileError, match="its folder cannot be written"):
            swept()


def test_a_disk_that_is_full_ends_the_sweep_and_loses_nothing(monkeypatch):
    whole = store_module.append

    def append(stream, line):
        if line.startswith(b'{"case": 3'):
            whole(stream, line[:40])
            raise OSError(28, "No space left on device")
        whole(stream, line)

    full = pytest.raises(FileError, match=r"index.jsonl: it cannot be written \(No space left on device\); make room")
    with monkeypatch.context() as patch, full:
        patch.setattr(store_module, "append", append)
        swept()
    _, tasks = swept()
    assert not {0, 1, 2, 3} & set(tasks)  # the small result of case 3 had been written
    swept("whole")
    assert table() == table("whole")
