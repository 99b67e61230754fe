"""Commands where disks are full, names strange, streams closed: nothing is lost, and one sentence is told."""

from __future__ import annotations

import os
import resource
import shutil
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import MappingProxyType
from typing import NamedTuple

from .processes import Run

TRAJOPT = [sys.executable, "-c", "from trajopt.cli.main import main; main()"]
YAML = """
trajopt: 1
name: NAME
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 4}]
"""
LONG = "n" * 252 + ".h5"  # 255 bytes, the most that a name may have
CJK = "日本語.h5"
LATIN = {"PYTHONIOENCODING": "latin-1"}
PLAIN = {"LC_ALL": "C", "PYTHONUTF8": "0"}


class Case(NamedTuple):
    """arguments: what is typed, in a folder with a.yaml and cjk.yaml. code: that it must end with.

    prepare: done in the folder before; limit: of the size of files, in bytes. environment: beside the usual one.
    streams: shell redirections. made: the file that must be a result afterwards, and whole.
    """

    name: str
    arguments: list[str | bytes]
    code: int
    prepare: Callable[[Path], object] = lambda folder: None
    limit: int = 0
    environment: Mapping[str, str] = MappingProxyType({})
    streams: str = ""
    made: str = ""


def _solve(*more: str | bytes) -> list[str | bytes]:
    return ["solve", "a.yaml", "-q", *more]


def _earlier(folder: Path) -> None:
    subprocess.run([*TRAJOPT, "solve", "a.yaml", "-q"], cwd=folder, check=True)


def _read_only(folder: Path) -> None:
    _earlier(folder)
    (folder / "a.h5").chmod(0o444)


def _linked(folder: Path) -> None:
    (folder / "there").mkdir()
    (folder / "a.h5").symlink_to("there/real.h5")


def _left_behind(folder: Path) -> None:
    """The temporary file of a process that was killed."""
    dead = subprocess.Popen(["true"])
    dead.wait()
    machine = "".join(c for c in os.uname().nodename if c.isalnum())[:30]
    (folder / f".trajopt-{machine}-{dead.pid}-x.h5").touch()


CASES = [
    Case("a plain one", _solve(), 0, made="a.h5"),
    Case("a name of 255 bytes", _solve("-o", LONG), 0, made=LONG),
    Case("a name too long", _solve("-o", "n" * 300 + ".h5"), 3),
    Case("a folder's name too long", _solve("-o", "n" * 300 + "/a.h5"), 3),
    Case("a name in Chinese", _solve("-o", CJK), 0, made=CJK),
    Case("spaces and a line break", _solve("-o", "a b\nc.h5"), 0, made="a b\nc.h5"),
    Case("a name that is not UTF-8", _solve("-o", b"a\xff.h5"), 0, made=os.fsdecode(b"a\xff.h5")),
    Case("a value that is not UTF-8", _solve("--set", b"name=\xff"), 2),
    Case("a path that is not UTF-8", _solve("--set", b"\xff=1"), 2),
    Case("a folder to be made as target", _solve("-o", "d.h5/"), 0, made="d.h5/a.h5"),
    Case("a folder as target", _solve("-o", "d.h5"), 0, lambda folder: (folder / "d.h5").mkdir(), made="d.h5/a.h5"),
    Case("a device as target", _solve("-o", "/dev/null"), 3),
    Case("a full device as target", _solve("-o", "/dev/full"), 3),
    Case("a pipe as target", _solve("-o", "fifo.h5"), 3, lambda folder: os.mkfifo(folder / "fifo.h5")),
    Case("a link as target", _solve(), 0, _linked, made="there/real.h5"),
    Case("a link in a circle", _solve("-o", "c.h5"), 3, lambda folder: (folder / "c.h5").symlink_to("c.h5")),
    Case("a link to nowhere", _solve("-o", "n.h5"), 3, lambda folder: (folder / "n.h5").symlink_to("none/n.h5")),
    Case("no such folder", _solve("-o", "none/a.h5"), 3),
    Case("a file as folder", _solve("-o", "a.yaml/a.h5"), 3),
    Case("a read-only result", _solve(), 3, _read_only, made="a.h5"),
    Case("a read-only result, forced", _solve("--force"), 0, _read_only, made="a.h5"),
    Case("a text as target", _solve("-o", "a.yaml"), 3),
    Case("a size limit", _solve(), 3, _earlier, limit=4096, made="a.h5"),
    Case("a size limit, first", _solve(), 3, limit=4096),
    Case("what a kill left", _solve(), 0, _left_behind, made="a.h5"),
    Case("full standard output", ["solve", "a.yaml"], 3, streams=">/dev/full", made="a.h5"),
    Case("help to a full device", ["--help"], 3, streams=">/dev/full"),
    Case("list to a full device", ["list"], 3, streams=">/dev/full"),
    Case("methods to a reader that goes", ["methods"], 0, streams="| head -c 1"),
    Case("closed standard output", ["solve", "a.yaml"], 0, streams=">&-", made="a.h5"),
    Case("closed standard error", ["solve", "a.yaml"], 0, streams="2>&-", made="a.h5"),
    Case("all streams closed", ["solve", "a.yaml"], 0, streams="<&- >&- 2>&-", made="a.h5"),
    Case("closed standard input", ["solve", "-"], 2, streams="<&-"),
    Case("latin-1, a Chinese name", ["solve", "cjk.yaml"], 0, environment=LATIN, made="cjk.h5"),
    Case("LANG=C, a Chinese name", ["solve", "cjk.yaml"], 0, environment=PLAIN, made="cjk.h5"),
    Case("no HOME, no TERM", ["solve", "a.yaml"], 0, environment={"HOME": "/none", "TERM": ""}, made="a.h5"),
    Case("PYTHONOPTIMIZE=1", ["solve", "a.yaml"], 0, environment={"PYTHONOPTIMIZE": "1"}, made="a.h5"),
    Case("PYTHONOPTIMIZE=2", ["solve", "a.yaml"], 0, environment={"PYTHONOPTIMIZE": "2"}, made="a.h5"),
    Case("a pipe as result", ["show", "fifo.h5"], 3, lambda folder: os.mkfifo(folder / "fifo.h5")),
    Case("a pipe as problem", ["check", "fifo.yaml"], 3, lambda folder: os.mkfifo(folder / "fifo.yaml")),
    Case("a problem's name too long", ["check", "n" * 300 + ".yaml"], 3),
]  # fmt: skip


def runs(cases: list[Case], folder: Path) -> Iterator[Run]:
    """The run of each case, in a folder of its own; what it lost is told in `err`."""
    for number, case in enumerate(cases):
        own = folder / str(number)
        own.mkdir()
        (own / "a.yaml").write_text(YAML.replace("NAME", "plain"))
        (own / "cjk.yaml").write_text(YAML.replace("NAME", "日本語"), encoding="utf-8")
        case.prepare(own)
        yield _run(case, own)
        shutil.rmtree(own)


def _run(case: Case, folder: Path) -> Run:
    def limited() -> None:
        if case.limit:
            resource.setrlimit(resource.RLIMIT_FSIZE, (case.limit, case.limit))

    typed = ["bash", "-c", f'set -o pipefail; "$@" {case.streams}', "trajopt", *TRAJOPT, *case.arguments]
    environment = {**os.environ, "TMPDIR": str(folder), **case.environment}
    if case.limit:
        environment["PYTHONDONTWRITEBYTECODE"] = "1"  # Python keeps half a .pyc, and nothing could import it again
    done = subprocess.run(
        typed, cwd=folder, env=environment, capture_output=True, timeout=600, preexec_fn=limited, check=False
    )
    out, err = (own.decode(errors="replace") for own in (done.stdout, done.stderr))
    err += _lost(case, folder)
    return Run(case.name, "disk", done.returncode, out, err, 0.0, "", frozenset({case.code}))


def _lost(case: Case, folder: Path) -> str:
    """What is not as it should be in the folder: a result that is missing or not whole, a temporary file."""
    from trajopt.problems.errors import FileError
    from trajopt.results.file.summary import summarize

    told = [f"Traceback: {own.name} was left" for own in folder.glob(".trajopt-*")]
    if case.made:
        try:
            summarize(folder / case.made)
        except FileError as error:
            told.append(f"Traceback: {error}")
    return "\n".join(told)
