"""The folder of a sweep. Whatever is killed, at any moment: no finished case is lost, nothing broken is read as good.

    sweep.json              what is swept: the text of the file, overrides, axes; a folder has one sweep
    cases/<key>.npz         one small result a case: its record as JSON, its curves and, with `--chain`, multipliers,
                            for a neighbour to start from; written under another name, flushed to disk and renamed; each
                            part with a check sum
    results/<key>.h5        the full result, with `--keep full`
    index.jsonl             one line a case when it is finished, with all of its record; of a case the last line counts,
                            and one that is solved before others; each shard has its own, index-2-of-8.jsonl
    index.csv, sweep.h5     the table and the arrays, made of the index whenever a sweep ends

The small result is written before the line of the index: a case that was killed in between is found by its file.
"""

from __future__ import annotations

import errno
import json
import os
from collections.abc import Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager, suppress
from io import FileIO
from pathlib import Path
from typing import Any, cast

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import PREFIX, check_writable, write_whole
from .case import Answer, Curves, Left, is_record
from .locks import Lock, locked
from .plan import Plan
from .small import BROKEN, packed, unpacked

FORMAT, VERSION = "trajopt sweep", 1
ABOUT, CASES, RESULTS = "sweep.json", "cases", "results"
TABLE, ARRAYS = "index.csv", "sweep.h5"
RECENT = 64
"""Cases whose small results are at hand for their neighbours, which mostly come next."""
_COMPARED = {"text": "problem file", "overrides": "overrides", "design": "design", "axes": "axes", "chain": "chaining"}


class Store:
    """An open folder: this process, or one shard of several, is the only one that adds to its index."""

    def __init__(self, folder: Path, plan: Plan, shard: tuple[int, int] | None = None) -> None:
        self.folder, self.plan = folder, plan
        self.index = folder / ("index-{}-of-{}.jsonl".format(*shard) if shard else "index.jsonl")
        self.shared = shard is not None
        self.records: dict[int, dict[str, Any]] = {}
        self.recent: dict[int, Left] = {}
        self.locks: list[Lock] = []
        self.stream: FileIO | None = None

    def open(self, about: Mapping[str, Any], force: bool = False, resume: bool = False) -> None:
        """Make the folder, or read what is in it.

        about: what is swept, see `about`.
        force: whether a sweep that is there is thrown away.
        resume: whether there has to be one.

        Raises SpecError if the folder holds another sweep or something else, or another process is at work in it;
        FileError if it cannot be written.
        """
        self._make(resume)
        self._lock()
        try:
            self._begin(about, force)
        except BaseException:
            self.close()
            raise

    def _begin(self, about: Mapping[str, Any], force: bool) -> None:
        with self.alone():
            if force:
                self._clear()
            self._agree(about)
        if not self.shared:
            self._tidy()
        for name in (CASES, RESULTS):
            (self.folder / name).mkdir(exist_ok=True)
        self.records = records_in(self.folder, self.plan)
        self._append()

    def _make(self, resume: bool) -> None:
        where = str(self.folder)
        if resume and not (self.folder / ABOUT).exists():
            raise SpecError(Mistake(where, "there is no sweep to resume", "start it without --resume"))
        try:
            self.folder.mkdir(exist_ok=True)
        except FileExistsError as error:
            raise SpecError(Mistake(where, "it is no folder", "choose another with -o")) from error
        except OSError as error:
            missing = not self.folder.parent.is_dir()
            what = "the folder around it does not exist" if missing else f"it cannot be made ({error.strerror})"
            raise FileError(Mistake(where, what, "choose another with -o")) from error
        others = [path.name for path in self.folder.iterdir() if not path.name.startswith(".")]
        if others and ABOUT not in others:
            raise SpecError(Mistake(where, "the folder is not empty and holds no sweep", "choose another with -o"))
        check_writable(self.folder / ABOUT)

    def _lock(self) -> None:
        """A whole sweep has the folder for itself; shards share it, and each has its own index."""
        wanted = [(self.folder / ".lock", not self.shared)]
        wanted += [(self.folder / f".{self.index.name}.lock", True)] if self.shared else []
        for path, alone in wanted:
            lock = Lock(path)
            if not lock.take(alone, wait=False):
                self.close()
                what = "another trajopt sweep is at work in this folder"
                raise SpecError(Mistake(str(self.folder), what, "wait until it has ended, or choose another with -o"))
            self.locks.append(lock)

    def _agree(self, about: Mapping[str, Any]) -> None:
        """Write what is swept, or compare it with what is there."""
        path = self.folder / ABOUT
        if not path.exists():
            write_whole(path, json.dumps(about, indent=1))
            return
        remedy = "choose another folder with -o, or start anew with --force"
        known = stored_about(self.folder, remedy)
        differ = [words for key, words in _COMPARED.items() if known.get(key) != about[key]]
        if differ:
            what = f"the folder holds another sweep ({' and '.join(differ)} differ)"
            raise SpecError(Mistake(str(self.folder), what, remedy))

    def _clear(self) -> None:
        """Remove what a sweep has made, and nothing else."""
        for folder, pattern in ((CASES, "*.npz"), (RESULTS, "*.h5"), ("", "index*.jsonl")):
            for path in (self.folder / folder).glob(pattern):
                path.unlink()
        for name in (TABLE, ARRAYS, ABOUT):
            (self.folder / name).unlink(missing_ok=True)

    def _tidy(self) -> None:
        """Remove half-written files of a process that was killed."""
        for folder in (CASES, RESULTS, ""):
            for path in (self.folder / folder).glob(f"{PREFIX}*"):
                path.unlink()

    def refreshed(self) -> dict[int, dict[str, Any]]:
        """The records with those that the other shards have finished by now."""
        if self.shared:
            self.records = {**records_in(self.folder, self.plan), **self.records}
        return dict(sorted(self.records.items()))

    def alone(self) -> AbstractContextManager[None]:
        """A block in which no other shard is."""
        return locked(self.folder / ".setup")

    def _append(self) -> None:
        """Open the index; a torn last line, of a process that was killed, is ended, so that the next one is whole."""
        with self._told(self.index):
            self.stream = self.index.open("a+b", buffering=0)
            size = self.stream.seek(0, os.SEEK_END)
            if size:
                self.stream.seek(size - 1)
                if self.stream.read(1) != b"\n":
                    append(self.stream, b"\n")

    def finished(self, number: int, full: bool) -> bool:
        """Whether a case is solved, and all is there that should be kept of it."""
        record = self.records.get(number)
        return record is not None and record["solved"] and (not full or self.result(record).exists())

    def result(self, record: Mapping[str, Any]) -> Path:
        """The place of the full result of a case."""
        return self.folder / RESULTS / f"{record['key']}.h5"

    def keep(self, answer: Answer) -> None:
        """Write all that is kept of a case. Raises FileError."""
        record = answer.record
        line = json.dumps(record, allow_nan=False).encode()
        if record["key"]:
            if answer.image:
                write_whole(self.result(record), answer.image)
            write_whole(self.folder / CASES / f"{record['key']}.npz", packed(line, answer.left))
        with self._told(self.index):
            append(self.stream, line + b"\n")
        self.records[record["case"]] = record
        self.recent[record["case"]] = answer.left
        if len(self.recent) > RECENT:
            del self.recent[next(iter(self.recent))]

    def left(self, number: int) -> Left | None:
        """What a solved case leaves for its neighbours; None if it is not solved, or that is lost."""
        record = self.records.get(number)
        if not record or not record["solved"]:
            return None
        if number in self.recent:
            return self.recent[number]
        small = _small(self.folder, record["key"])
        return small[1] if small else None

    @contextmanager
    def _told(self, path: Path) -> Iterator[None]:
        try:
            yield
        except OSError as error:
            what = f"it cannot be written ({error.strerror or error})"
            raise FileError(
                Mistake(str(path), what, "make room there; the same command goes on where it ended")
            ) from error

    def close(self) -> None:
        """Another process may add to the folder."""
        if self.stream is not None:
            self.stream.close()
            self.stream = None
        for lock in self.locks:
            lock.release()
        self.locks = []


def about(plan: Plan, text: str, file: str, overrides: list[str], chain: bool) -> dict[str, Any]:
    """What tells one sweep from another, for `Store.open`.

    plan: its cases.
    text: of the problem file.
    file: its name, which is told only.
    overrides: for every case.
    chain: whether cases start from their neighbours.
    """
    axes = [{"path": axis.path, "values": list(axis.values)} for axis in plan.axes]
    head = {"format": FORMAT, "format_version": VERSION, "file": file, "design": plan.design}
    return {**head, "axes": axes, "overrides": list(overrides), "chain": chain, "text": text}


def stored_about(folder: Path, remedy: str) -> dict[str, Any]:
    """What `about` has written into a folder. Raises SpecError with the remedy if it is none of this version."""
    path = folder / ABOUT
    try:
        known = json.loads(path.read_text(encoding="utf-8"))
        there = known["format"], known["format_version"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError) as error:
        raise SpecError(Mistake(str(path), "it cannot be read", remedy)) from error
    if there != (FORMAT, VERSION):
        raise SpecError(Mistake(str(path), "it is of another version of trajopt", remedy))
    return cast(dict[str, Any], known)


def records_in(folder: Path, plan: Plan) -> dict[int, dict[str, Any]]:
    """The last record of each case of a plan that a folder has; one whose small result is missing or broken is none."""
    records: dict[int, dict[str, Any]] = {}
    for path in sorted(folder.glob("index*.jsonl")):
        for line in path.read_bytes().splitlines():
            record = _json(line)
            if _belongs(record, plan) and not (records.get(record["case"], {}).get("solved") and not record["solved"]):
                records[record["case"]] = record
    lost = {number for number, r in records.items() if r["solved"] and _small(folder, r["key"]) is None}
    records = {number: record for number, record in records.items() if number not in lost}
    known = {record["key"] for record in records.values()}
    for path in (folder / CASES).glob("[!.]*.npz"):
        if path.stem not in known and (small := _small(folder, path.stem)) and _belongs(small[0], plan):
            records.setdefault(small[0]["case"], small[0])
    return dict(sorted(records.items()))


def _belongs(record: Any, plan: Plan) -> bool:
    """Whether it is a record of a case of the plan."""
    if not is_record(record):
        return False
    number = record["case"]
    return 0 <= number < len(plan) and record["values"] == plan.values(number)


def curves_in(folder: Path, record: Mapping[str, Any]) -> Curves | None:
    """The curves of a case that is solved; None if there are none."""
    small = _small(folder, record["key"]) if record["solved"] else None
    return small[1].curves if small else None


def _small(folder: Path, key: str) -> tuple[dict[str, Any], Left] | None:
    """What the small result of a case holds; None if it is missing or broken."""
    with suppress(*BROKEN):
        return unpacked((folder / CASES / f"{key}.npz").read_bytes())
    return None


def append(stream: FileIO | None, line: bytes) -> None:
    """Write a line at once, so that no part of another can stand in it. Raises OSError."""
    assert stream is not None  # the folder is open
    if stream.write(line) < len(line):
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def _json(line: bytes) -> Any:
    try:
        return json.loads(line)
    except (ValueError, RecursionError):
        return None
