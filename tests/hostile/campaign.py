"""Every command that reads a result, run on bad files: each run is a process of its own, limited in time and memory."""

from __future__ import annotations

import os
import resource
import shutil
import signal
import sys
import time
import traceback
from collections import Counter
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib
from typer.main import get_command

from trajopt.cli.app import app
from trajopt.problems.errors import TrajoptError

from .files import TINY, Bad

TYPED = get_command(app)
PROCESSOR, WAITING = 20, 60  # seconds of a run; the slowest on a good file, verify of a biped, takes 3
MEMORY = 2 * 2**30  # bytes that a run may take beyond what is there
CODES = {0, 1, 2, 3, 4}

COMMANDS = {
    "show": ["show", "FILE"],
    "json": ["show", "FILE", "--json"],
    "compare": ["compare", "GOOD", "FILE"],
    "compare with it": ["compare", "FILE", "GOOD"],
    "guess": ["solve", "tiny.yaml", "--guess", "FILE", "-q", "-o", "guess.h5", "--force"],
    "explain": ["explain", "FILE"],
    "plot": ["plot", "FILE", "-o", "plot.png", "--force"],
    "errors": ["plot", "FILE", "--error", "--mesh", "-o", "errors.pdf", "--force"],
    "animate": ["animate", "FILE", "-o", "poses.png", "--frames", "2", "--force"],
    "report": ["report", "FILE", "-o", "page.html", "--no-verify", "--force"],
    "verify": ["verify", "FILE"],
    "read": ["FILE"],  # trajopt.read, from Python
    "over it": ["solve", "tiny.yaml", "-q", "-o", "FILE"],
}
"""Name -> what is typed. The last one changes the file."""


@dataclass
class Run:
    """How a command ended: an exit code, or minus the signal that ended it; what it wrote; how long it took."""

    bad: str
    command: str
    code: int
    out: str
    err: str
    seconds: float

    @property
    def fault(self) -> str:
        """What is wrong with how it ended; "" for nothing."""
        if self.code < 0:
            return (
                "hang"
                if -self.code in (signal.SIGALRM, signal.SIGXCPU, signal.SIGKILL)
                else f"killed by signal {-self.code}"
            )
        if "Traceback" in self.err or self.code not in CODES:
            return "traceback"
        return self._told_badly()

    def _told_badly(self) -> str:
        lines = self.err.splitlines()
        if self.code in (2, 3) and not any(line.startswith("error: ") and len(line) > 20 for line in lines):
            return "no sentence"
        if self.code == 3 and (len(lines) > 1 or "bad.h5" not in self.err):
            return "not one sentence about the file"
        if any("Warning:" in line for line in lines):
            return "warning of a library"
        controls = any((ord(c) < 32 and c not in "\n\t") or ord(c) == 127 for c in self.out + self.err)
        return "control characters" if controls else ""


@dataclass
class Count:
    """What a campaign has come to."""

    files: int = 0
    runs: int = 0
    codes: Counter[int] = field(default_factory=Counter)
    faults: list[Run] = field(default_factory=list)

    def add(self, run: Run) -> None:
        self.runs += 1
        self.codes[run.code] += 1
        if run.fault:
            self.faults.append(run)


def campaign(
    bad: Iterable[Bad], good: Path, folder: Path, commands: Iterable[str] = COMMANDS
) -> Iterator[tuple[Bad, Iterator[Run]]]:
    """Make each file in the folder, with the runs of each command on it, to be gone through before the next file.

    bad: the files to be made.
    good: a good result, to compare with.
    folder: to work in.
    commands: names in COMMANDS.
    """
    matplotlib.use("agg")
    (folder / "tiny.yaml").write_text(TINY)
    for own in bad:
        path = folder / "bad.h5"
        _remove(path)
        shutil.copy(own.source, path)
        try:
            own.damage(path)
        except (RuntimeError, ValueError, TypeError, KeyError, OSError, IndexError):
            continue  # what cannot be made, as a text of 64 kB in an old attribute
        yield own, (_run(name, own.name, good, folder) for name in commands)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _run(name: str, bad: str, good: Path, folder: Path) -> Run:
    """One command in a process of its own."""
    spelt = {"FILE": "bad.h5", "GOOD": str(good)}
    arguments = [spelt.get(word, word) for word in COMMANDS[name]]
    sys.stdout.flush()
    sys.stderr.flush()
    start = time.perf_counter()
    child = os.fork()
    if not child:
        _child(name, arguments, folder)
    _, status = os.waitpid(child, 0)
    seconds = time.perf_counter() - start
    out, err = ((folder / stream).read_text(errors="replace") for stream in ("out", "err"))
    return Run(bad, name, os.waitstatus_to_exitcode(status), out, err, seconds)


def _child(name: str, arguments: list[str], folder: Path) -> None:
    """Never returns."""
    code = 1
    try:
        os.chdir(folder)
        for stream, descriptor in (("out", 1), ("err", 2)):
            os.dup2(os.open(stream, os.O_WRONLY | os.O_CREAT | os.O_TRUNC), descriptor)
        sys.stdout, sys.stderr = (os.fdopen(descriptor, "w", errors="backslashreplace") for descriptor in (1, 2))
        pages = int(Path("/proc/self/statm").read_text().split()[0])
        limit = pages * resource.getpagesize() + MEMORY
        resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
        resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
        used = int(sum(os.times()[:2]))
        resource.setrlimit(resource.RLIMIT_CPU, (used + PROCESSOR, used + PROCESSOR))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(WAITING)
        code = _read(arguments[0]) if name == "read" else _type(arguments)
        sys.stdout.flush()
        sys.stderr.flush()
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    os._exit(code)


def _type(arguments: list[str]) -> int:
    """The exit code of a command line, as `main` has it."""
    sys.argv = ["trajopt", *arguments]
    try:
        TYPED(prog_name="trajopt")
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    return 0


def _read(path: str) -> int:
    import trajopt

    try:
        trajopt.read(path)
    except TrajoptError as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    return 0


def preload() -> None:
    """Import once what each run would have to."""
    import trajopt.results.audit.stored
    import trajopt.results.compare
    import trajopt.results.file.guess
    import trajopt.results.file.write
    import trajopt.results.pictures.animate
    import trajopt.results.pictures.error_plots
    import trajopt.results.pictures.mesh_plots
    import trajopt.results.python.solving
    import trajopt.results.report.result
    import trajopt.results.verify
    import trajopt.transcription.failure.relax
    import trajopt.transcription.solve  # noqa: F401
