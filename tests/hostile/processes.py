"""One command in a process of its own, limited in time and memory, and what is wrong with how it ended."""

from __future__ import annotations

import io
import os
import resource
import signal
import sys
import traceback
from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import matplotlib
from matplotlib.figure import Figure
from typer.main import get_command

from trajopt.cli.app import app

TYPED = get_command(app)
WAITING = (
    600  # seconds: for what waits without using the processor, which other work on the machine may also bring about
)
MEMORY = 2 * 2**30  # bytes that a run may take beyond what is there
CODES = {0, 1, 2, 3, 4}
PREFIXES = ("error: ", "warning: ", "note: ", "not solved: ")


@dataclass
class Run:
    """How a command ended: an exit code, or minus the signal that ended it; what it wrote; how long it took."""

    bad: str
    command: str
    code: int
    out: str
    err: str
    seconds: float
    file: str = "bad.h5"
    codes: frozenset[int] = frozenset(CODES)

    @property
    def fault(self) -> str:
        """What is wrong with how it ended; "" for nothing."""
        if self.code < 0:
            hangs = (signal.SIGALRM, signal.SIGXCPU, signal.SIGKILL)
            return "hang" if -self.code in hangs else f"killed by signal {-self.code}"
        if "Traceback" in self.err or self.code not in CODES:
            return "traceback"
        if self.code not in self.codes:
            return f"exit code {self.code}"
        return self._told_badly()

    def _told_badly(self) -> str:
        lines = self.err.splitlines()
        if self.code in (2, 3) and not any(line.startswith("error: ") and len(line) > 20 for line in lines):
            return "no sentence"
        if self.code == 3 and (len(lines) > 1 or self.file not in self.err):
            return "not one sentence about the file"
        if any("Warning:" in line for line in lines):
            return "warning of a library"
        if any(not line.startswith(PREFIXES) for line in lines if line):
            return "words of a library"
        controls = any((ord(c) < 32 and c not in "\n\t") or 127 <= ord(c) < 160 for c in self.out + self.err)
        return "control characters" if controls else ""


@dataclass
class Count:
    """What a campaign has come to."""

    files: int = 0
    runs: int = 0
    unmade: list[str] = field(default_factory=list)
    codes: Counter[int] = field(default_factory=Counter)
    faults: list[Run] = field(default_factory=list)

    def add(self, run: Run) -> None:
        self.runs += 1
        self.codes[run.code] += 1
        if run.fault:
            self.faults.append(run)


def alone(bad: str, command: str, folder: Path, work: Callable[[], int], processor: int, file: str = "bad.h5") -> Run:
    """What a function does in a process of its own, in the folder; its value is the exit code.

    bad, command, file: names, for the report.
    folder: the current one of the process, which gets files `out` and `err` of what it wrote.
    work: the function.
    processor: seconds of CPU time that it may take.
    """
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if not child:
        _child(folder, work, processor)
    _, status, used = os.wait4(child, 0)
    out, err = ((folder / stream).read_text(errors="replace") for stream in ("out", "err"))
    return Run(bad, command, os.waitstatus_to_exitcode(status), out, err, used.ru_utime + used.ru_stime, file)


def _child(folder: Path, work: Callable[[], int], processor: int) -> None:
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
        resource.setrlimit(resource.RLIMIT_CPU, (processor, processor))
        signal.signal(signal.SIGALRM, signal.SIG_DFL)
        signal.alarm(WAITING)
        code = work()
        sys.stdout.flush()
        sys.stderr.flush()
    except BaseException:
        traceback.print_exc()
        sys.stderr.flush()
    os._exit(code)


def typed(arguments: Sequence[str]) -> int:
    """The exit code of a command line, as `main` has it."""
    sys.argv = ["trajopt", *arguments]
    try:
        TYPED(prog_name="trajopt")
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
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
    import trajopt.transcription.collocation.model
    import trajopt.transcription.failure.relax
    import trajopt.transcription.solve  # noqa: F401

    matplotlib.use("agg")
    figure = Figure()
    figure.text(0, 0, "a")
    figure.savefig(io.BytesIO(), format="pdf")  # which finds the fonts
