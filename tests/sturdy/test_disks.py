"""Disks and streams: in small what `python -m tests.hostile disks` does at length; and files, inside one process."""

import os
import subprocess
from types import SimpleNamespace

import pytest
from hostile.disks import CASES, runs
from hostile.full_disk import runs as full_disks

from trajopt.cli.streams import flushed_output
from trajopt.problems import files
from trajopt.problems.errors import FileError, SpecError
from trajopt.problems.files import check_not_protected, check_writable, replacing
from trajopt.problems.yaml.document import Document
from trajopt.problems.yaml.overrides import override

QUICK = ["a size limit", "help to a full device", "latin-1, a Chinese name", "PYTHONOPTIMIZE=2"]


def test_a_sample_of_the_campaign(tmp_path):
    for run in runs([case for case in CASES if case.name in QUICK], tmp_path):
        assert not run.fault, run


def test_a_disk_that_is_full(tmp_path):
    """A table that does not fit any more: one sentence, and what was there stays whole."""
    try:
        (run,) = full_disks(tmp_path, ["table"], (4096,))
    except PermissionError as refused:
        pytest.skip(str(refused))
    assert run.code == 3 and not run.fault and "no space left" in run.err, run


@pytest.mark.parametrize("name", ["n" * 252 + ".h5", "é" * 126 + ".h5", "." * 200 + "x", "a b\nc.h5"])
def test_every_name_that_a_file_may_have_can_be_written(tmp_path, name):
    with replacing(tmp_path / name) as temporary:
        temporary.write_text("new")
    assert [own.name for own in tmp_path.iterdir()] == [name]


@pytest.mark.parametrize("name", ["n" * 300, "none/a.h5", "n" * 300 + "/a.h5", "loop"])
def test_what_cannot_be_written_is_told_by_its_name(tmp_path, name):
    (tmp_path / "loop").symlink_to("loop")
    for attempt in (check_writable, lambda path: replacing(path).__enter__()):
        with pytest.raises(FileError) as caught:
            attempt(tmp_path / name)
        assert str(caught.value).startswith(str(tmp_path)) and "\n" not in str(caught.value)


@pytest.mark.parametrize("target", ["/dev/zero", "none/a.h5", "."])
def test_a_link_to_what_cannot_be_written_is_told_by_both_names(tmp_path, target):
    (tmp_path / "a.h5").symlink_to(target)
    with pytest.raises(FileError) as caught:
        check_writable(tmp_path / "a.h5")
    assert str(caught.value).startswith(f"{tmp_path}/a.h5 -> /")


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "there").mkdir()
    link = tmp_path / "a.h5"
    link.symlink_to("there/real.h5")
    with replacing(link) as temporary:
        temporary.write_text("new")
    assert link.is_symlink() and (tmp_path / "there" / "real.h5").read_text() == "new"


def test_a_read_only_file_is_not_replaced_unasked(tmp_path):
    path = tmp_path / "a.h5"
    path.touch(0o444)
    with pytest.raises(FileError, match="it is read-only"):
        check_not_protected(path)
    path.chmod(0o644)
    check_not_protected(path)


def test_what_a_killed_process_left_is_removed_by_the_next_one(tmp_path):
    with subprocess.Popen(["true"]) as dead:
        dead.wait()
    left, other, own = (
        tmp_path / f"{files.PREFIX}{machine}-{process}-x.h5"
        for machine, process in ((files._machine(), dead.pid), ("another", dead.pid), (files._machine(), os.getpid()))
    )
    for path in (left, other, own):
        path.touch()
    with replacing(tmp_path / "a.h5") as temporary:
        temporary.touch()
    assert not left.exists() and other.exists() and own.exists()


def test_trouble_with_a_file_is_not_told_of_standard_output():
    with pytest.raises(FileError, match="nowhere"), flushed_output():
        os.stat("/nowhere/at all")


@pytest.mark.parametrize("text", ["name=a\udcffb", "\udcff=1", "name=\x1b[31m"])
def test_what_is_no_text_in_an_override(text):
    with pytest.raises(SpecError, match="it holds what is no text"):
        override(Document({"name": "a"}), [text])


def test_a_signal_after_the_last_iteration_takes_nothing_away(folder, monkeypatch):
    """As if SIGTERM came between the solve and its result."""
    from command_line import trajopt

    from trajopt.cli.solving import solve

    class Late(solve.Stop):
        def __init__(self):
            super().__init__()
            self.asked = SimpleNamespace(kept=False)

        def __call__(self):
            return self.asked.kept

    def kept(job, solution, kept=solve._kept):
        stops[-1].asked.kept = True
        return kept(job, solution)

    stops = []
    monkeypatch.setattr(solve, "Stop", lambda: stops.append(Late()) or stops[-1])
    monkeypatch.setattr(solve, "_kept", kept)
    assert trajopt("solve", "block_move_min_force", "-q").exit_code == 0
