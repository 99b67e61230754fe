"""The cache folder as a foreign one: what is not the user's, or not whole, is as if it were not there."""

import os
import resource
import subprocess
import sys
import threading
from pathlib import Path

import pytest

from trajopt.transcription.cache import entries, kept
from trajopt.transcription.cache.entries import clear, file_name_of, read_entry, write_entry

NAME, OTHER = file_name_of(b"one"), file_name_of(b"other")


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache folder of the test's own, which is not there yet."""
    monkeypatch.setenv("TRAJOPT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


@pytest.fixture
def filled(cache):
    write_entry(NAME, b"what was made")
    assert read_entry(NAME) == b"what was made"
    return cache


def test_what_is_written_is_read_and_is_the_users_alone(filled):
    assert read_entry(OTHER) is None
    assert filled.stat().st_mode & 0o777 == 0o700 and (filled / NAME).stat().st_mode & 0o777 == 0o600
    write_entry(NAME, b"made again")
    assert read_entry(NAME) == b"made again" and [path.name for path in filled.iterdir()] == [NAME]


def flipped(content: bytes, at: int) -> bytes:
    return content[:at] + bytes([content[at] ^ 1]) + content[at + 1 :]


DAMAGES = {
    "a bit of the content": lambda content: flipped(content, len(content) - 1),
    "a bit of the digest": lambda content: flipped(content, len(entries.MAGIC)),
    "a bit of the head": lambda content: flipped(content, 0),
    "cut short": lambda content: content[:-1],
    "cut in the head": lambda content: content[:20],
    "empty": lambda content: b"",
    "longer": lambda content: content + b"x",
}


@pytest.mark.parametrize("damage", DAMAGES.values(), ids=DAMAGES)
def test_what_is_damaged_is_not_there(damage, filled):
    path = filled / NAME
    path.write_bytes(damage(path.read_bytes()))
    assert read_entry(NAME) is None
    write_entry(NAME, b"anew")
    assert read_entry(NAME) == b"anew"


def test_an_entry_under_the_name_of_another_is_not_there(filled):
    (filled / NAME).rename(filled / OTHER)
    assert read_entry(OTHER) is None


def to_nobody(path: Path) -> None:
    if os.geteuid():
        pytest.skip("only root can give a file away")
    os.chown(path, 65534, -1)


def by_a_link(path: Path) -> None:
    path.rename(path.with_name("elsewhere"))
    path.symlink_to("elsewhere")


def as_a_pipe(path: Path) -> None:
    path.unlink()
    os.mkfifo(path)


UNSAFE_FILES = {
    "others may write": lambda path: path.chmod(0o622),
    "another user's": to_nobody,
    "a link": by_a_link,
    "a pipe": as_a_pipe,
}
UNSAFE_FOLDERS = {
    "others may read": lambda path: path.chmod(0o750),
    "another user's": to_nobody,
    "a link": by_a_link,
}


@pytest.mark.parametrize("change", UNSAFE_FILES.values(), ids=UNSAFE_FILES)
def test_an_unsafe_file_is_not_read(change, filled):
    change(filled / NAME)
    assert read_entry(NAME) is None


@pytest.mark.parametrize("change", UNSAFE_FOLDERS.values(), ids=UNSAFE_FOLDERS)
def test_an_unsafe_folder_is_not_used(change, filled):
    change(filled)
    write_entry(OTHER, b"more")
    assert read_entry(NAME) is None and read_entry(OTHER) is None and not (filled / OTHER).exists()
    with pytest.raises(OSError):
        clear()


def test_a_place_that_cannot_be_made_is_none(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("TRAJOPT_CACHE", str(tmp_path / "file" / "cache"))
    write_entry(NAME, b"more")
    assert read_entry(NAME) is None and kept.made("kind", 1, lambda: "made") == "made"


@pytest.mark.parametrize(
    ("variables", "place"),
    [
        ({"XDG_CACHE_HOME": "/x", "HOME": "/h"}, "/x/trajopt"),
        ({"XDG_CACHE_HOME": "x", "HOME": "/h"}, "/h/.cache/trajopt"),
        ({"HOME": "/h"}, "/h/.cache/trajopt"),
        ({"TRAJOPT_CACHE": "/c", "HOME": "/h"}, "/c"),
        ({"TRAJOPT_CACHE": "off", "HOME": "/h"}, None),
        ({"HOME": "relative"}, None),
    ],
)
def test_its_place(variables, place, monkeypatch):
    for own in ("TRAJOPT_CACHE", "XDG_CACHE_HOME", "HOME"):
        monkeypatch.delenv(own, raising=False)
    for own, value in variables.items():
        monkeypatch.setenv(own, value)
    found = kept.place()
    assert found == (place and Path(place))


def test_a_full_disk_keeps_nothing_and_leaves_nothing(filled):
    """A limit on the size of files is to a writer what a full disk is: some bytes are written, then no more."""
    program = (
        "import resource, signal; signal.signal(signal.SIGXFSZ, signal.SIG_IGN);"
        "from trajopt.transcription.cache.entries import file_name_of, read_entry, write_entry;"  # else a .pyc is cut
        "resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000));"
        "write_entry(file_name_of(b'large'), bytes(100_000)); assert read_entry(file_name_of(b'large')) is None;"
        "write_entry(file_name_of(b'small'), b's'); assert read_entry(file_name_of(b'small')) == b's'"
    )
    subprocess.run([sys.executable, "-c", program], check=True)
    assert {path.name for path in filled.iterdir()} == {NAME, file_name_of(b"small")}


WRITER = """
import sys
from trajopt.transcription.cache.entries import file_name_of, read_entry, write_entry
for round in range(150):
    for k in range(4):
        payload = bytes([k]) * 20_000
        found = read_entry(file_name_of(bytes([k])))
        assert found in (None, payload), "half an entry was read"
        write_entry(file_name_of(bytes([k])), payload)
"""


def test_several_writers_at_once(cache):
    runs = [subprocess.Popen([sys.executable, "-c", WRITER]) for _ in range(3)]
    assert [run.wait() for run in runs] == [0, 0, 0]
    assert {path.name for path in cache.iterdir()} == {file_name_of(bytes([k])) for k in range(4)}


def test_threads_write_beside_each_other(cache):
    threads = [threading.Thread(target=write_entry, args=(NAME, bytes(50_000))) for _ in range(8)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert read_entry(NAME) == bytes(50_000) and len(list(cache.iterdir())) == 1


def test_what_was_used_longest_ago_goes_first(filled, monkeypatch):
    monkeypatch.setattr(entries, "LIMIT", 10_000)
    monkeypatch.setattr(entries, "MOST", 10)
    names = [file_name_of(b"many", bytes([k])) for k in range(30)]
    for k, own in enumerate(names):
        write_entry(own, bytes(10))
        os.utime(filled / own, (k, k))
        monkeypatch.setitem(entries._ahead, "bytes", 0.0)
    assert len(list(filled.iterdir())) <= 11 and read_entry(names[-1]) is not None and read_entry(names[0]) is None


def test_a_large_entry_is_not_kept(filled, monkeypatch):
    monkeypatch.setattr(entries, "LARGEST", 100)
    write_entry(OTHER, bytes(101))
    assert not (filled / OTHER).exists()


def test_what_a_killed_writer_left_goes(filled, monkeypatch):
    left, fresh = filled / ".left", filled / ".fresh"
    left.write_bytes(b"half")
    os.utime(left, (0, 0))
    fresh.write_bytes(b"half")
    monkeypatch.setitem(entries._ahead, "bytes", 0.0)
    write_entry(OTHER, b"more")
    assert not left.exists() and fresh.exists()


def test_use_is_noted(filled):
    os.utime(filled / NAME, (0, 0))
    assert read_entry(NAME) and (filled / NAME).stat().st_mtime > 1e9


def test_a_pickle_that_is_whole_and_cannot_be_loaded_is_not_there(cache):
    own = kept.name_of_kept("kind", "content")
    write_entry(own, b"cno_such_module\nthing\n.")
    assert kept.load_kept(own) is None and kept.made("kind", "content", lambda: 5) == 5 and kept.load_kept(own) == 5


def test_what_cannot_be_pickled_is_made_each_time(cache):
    made = kept.made("kind", "content", threading.Lock)
    assert made.acquire() and not kept.made("kind", "content", threading.Lock).locked()
    assert kept.name_of_kept("kind", threading.Lock()) is None


def test_memory_is_bounded_whatever_is_there(filled):
    """A sparse file of a terabyte in place of an entry is not read."""
    with (filled / NAME).open("r+b") as file:
        file.truncate(2**40)
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    assert read_entry(NAME) is None
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 50_000
