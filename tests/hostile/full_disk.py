"""Every command that writes, on a real disk (a tmpfs) with so many bytes left: what was there stays whole."""

from __future__ import annotations

import os
import subprocess
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from hashlib import sha256
from pathlib import Path

from .disks import TRAJOPT
from .processes import Run

SIZE = "24m"
"""Of the disk."""
LEFT = (0, 4096, 16384, 65536, 262144, 1048576)
"""Bytes that are left when a command begins."""
COMMANDS = {
    "solve": (["solve", "cartpole", "-q", "-o", "a.h5"], "a.h5"),
    "refine": (["solve", "cartpole", "-q", "--refine", "1e-6", "-o", "b.h5"], "b.h5"),
    "sweep": (["sweep", "block_move_min_force", "-q", "--over", "controls.u.upper=6,7,8", "-o", "cases"], "cases"),
    "report": (["report", "kept.h5", "--no-verify", "-o", "page.html"], "page.html"),
    "report of a sweep": (["report", "done", "-o", "done.html"], "done.html"),
    "table": (["table", "kept.h5", "--dense", "-o", "t.csv"], "t.csv"),
    "plot": (["plot", "kept.h5", "-o", "p.png"], "p.png"),
    "plot, pdf": (["plot", "kept.h5", "--error", "--mesh", "-o", "p.pdf"], "p.pdf"),
    "animate": (["animate", "kept.h5", "--frames", "10", "-o", "f.gif"], "f.gif"),
    "export": (["export", "cartpole", "e.nl"], "e.nl"),
    "init": (["init", "new.yaml"], "new.yaml"),
    "reproduce": (["reproduce", "block", "-o", "paper"], "paper"),
    "library": (["reproduce", "library", "--only", "block_move_min_force", "-o", "shelf"], "shelf"),
}
"""Name -> what is typed, and the file or folder that it writes."""


@contextmanager
def small_disk(folder: Path) -> Iterator[Path]:
    """A disk of its own at a new folder. Raises PermissionError where none may be mounted."""
    folder.mkdir()
    mounted = ["mount", "-t", "tmpfs", "-o", f"size={SIZE}", "tmpfs", str(folder)]
    if os.geteuid() or subprocess.run(mounted, capture_output=True, check=False).returncode:
        raise PermissionError("a disk of its own cannot be mounted here: that takes root")
    try:
        yield folder
    finally:
        subprocess.run(["umount", "--lazy", str(folder)], check=True)


def runs(folder: Path, names: Iterable[str] = COMMANDS, left: tuple[int, ...] = LEFT) -> Iterator[Run]:
    """Each command with each number of bytes left; what was lost is told in `err`."""
    with small_disk(folder / "disk") as disk:
        for typed in (["solve", "cartpole", "-q", "-o", "kept.h5"], [*COMMANDS["sweep"][0][:-1], "done"]):
            subprocess.run([*TRAJOPT, *typed], cwd=disk, check=True, capture_output=True)
        for name in names:
            typed, target = COMMANDS[name]
            for bytes_left in left:
                yield _run(name, typed, disk, target, bytes_left)


def _run(name: str, typed: list[str], disk: Path, target: str, left: int) -> Run:
    """One command on a disk that is full but for so many bytes; then the disk is emptied again."""
    before = _content(disk)
    filler = disk / "filler"
    free = os.statvfs(disk)
    with filler.open("wb") as stream:
        stream.truncate(0)
        os.posix_fallocate(stream.fileno(), 0, max(free.f_bavail * free.f_frsize - left, 1))
    done = subprocess.run([*TRAJOPT, *typed], cwd=disk, capture_output=True, text=True, timeout=600, check=False)
    filler.unlink()
    err = "\n".join(line for line in done.stderr.splitlines() if not line.startswith(f"{target}: "))
    err += "".join(f"\nTraceback: {own.name} was left" for own in disk.rglob(".trajopt-*"))
    after = _content(disk)
    err += "".join(f"\nTraceback: {own} was changed" for own in before if after.get(own) != before[own])
    if done.returncode == 3 and "space" not in err:
        err += "\nTraceback: it does not say why"
    if done.returncode == 0 and not (disk / target).exists():
        err += "\nTraceback: it was not written"
    for own in sorted(disk.rglob("*"), reverse=True):
        if own.is_dir() and not any(own.iterdir()):
            own.rmdir()
        elif own.is_file() and str(own.relative_to(disk)) not in before:
            own.unlink()
    return Run(f"{left} bytes left", name, done.returncode, done.stdout, err, 0.0, "", frozenset({0, 3}))


def _content(disk: Path) -> dict[str, str]:
    """File -> what identifies its content."""
    return {
        str(own.relative_to(disk)): sha256(own.read_bytes()).hexdigest() for own in disk.rglob("*") if own.is_file()
    }
