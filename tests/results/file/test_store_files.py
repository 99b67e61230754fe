"""Result files in the file system: nothing is ever lost, and what is no result is not read."""

import resource
from contextlib import contextmanager
from dataclasses import replace

import h5py
import numpy as np
import pytest
from stored import save, solved

from trajopt.problems.errors import FileError
from trajopt.results.file import write as store
from trajopt.results.file.door import FORMAT_VERSION, open_result
from trajopt.results.file.summary import summarize
from trajopt.results.file.write import check_target, write


def test_a_write_that_fails_leaves_the_old_file_and_nothing_else(tmp_path):
    path = save(tmp_path / "a.h5")
    before = path.read_bytes()
    spec, solution = solved("cartpole")
    with pytest.raises(TypeError):
        write(path, solution, object(), "{}", "")
    with pytest.raises(AttributeError):
        write(path, replace(solution, outcome=None), spec.text, "{}", "")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


@contextmanager
def largest_file(size: int):
    """A limit on the size of files stands in for a disk that is full: writing fails in the middle."""
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, hard))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))


@pytest.mark.parametrize("size", [0, 100, 50_000])
def test_a_full_disk(tmp_path, size):
    path = save(tmp_path / "a.h5")
    before = path.read_bytes()
    with largest_file(size), pytest.raises(FileError, match="cannot be written"):
        save(path, "cartpole")
    assert path.read_bytes() == before
    assert list(tmp_path.iterdir()) == [path]


def test_a_new_result_replaces_the_old_one(tmp_path):
    path = save(tmp_path / "a.h5", max_iter=2)
    save(path)
    assert summarize(path)["solved"]
    assert list(tmp_path.iterdir()) == [path]
    assert path.stat().st_mode & 0o777 == 0o666 & ~_umask(tmp_path)


def _umask(folder) -> int:
    probe = folder / "probe"
    probe.touch()
    mode = probe.stat().st_mode & 0o777
    probe.unlink()
    return 0o666 & ~mode


@pytest.mark.parametrize("content", [b"", b"not HDF5", b"\x89HDF\r\n\x1a\n then rubbish"])
def test_foreign_files_are_kept_and_not_read(tmp_path, content):
    path = tmp_path / "a.h5"
    path.write_bytes(content)
    with pytest.raises(FileError, match=r"no trajopt result.*--force"):
        check_target(path, "shot put")
    check_target(path, "shot put", force=True)
    with pytest.raises(FileError, match="cannot be read as HDF5"):
        summarize(path)
    assert path.read_bytes() == content


def test_half_a_result_is_not_read(tmp_path):
    path = save(tmp_path / "a.h5")
    path.write_bytes(path.read_bytes()[:10_000])
    with pytest.raises(FileError, match="cannot be read as HDF5"):
        summarize(path)


def test_other_hdf5_files_and_other_problems(tmp_path):
    path = save(tmp_path / "a.h5")
    check_target(path, "shot put")
    with pytest.raises(FileError, match="another problem, 'shot put'"):
        check_target(path, "cart-pole swing-up")
    with h5py.File(path, "a") as file:
        file.attrs["format_version"] = FORMAT_VERSION + 1
    with pytest.raises(FileError, match="update trajopt"):
        summarize(path)
    with h5py.File(path, "w") as file:
        file.attrs["format"] = np.arange(3)
    with pytest.raises(FileError, match="no trajopt result"), open_result(path):
        pass


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize(
    ("target", "words"),
    [
        ("nowhere/a.h5", "folder does not exist"),
        (".", "it is a folder"),
        ("/dev/full", "no ordinary file"),
        ("/proc/a.h5", "folder cannot be written"),
    ],
)
def test_targets_that_cannot_be_written(target, words):
    with pytest.raises(FileError, match=words):
        check_target(store.Path(target), "shot put", force=True)
