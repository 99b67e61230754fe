"""Every command that reads a result, run on bad files."""

from __future__ import annotations

import shutil
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

from trajopt.problems.errors import TrajoptError

from .files import TINY, Bad
from .processes import Run, alone, typed

PROCESSOR = 20  # seconds of a run; the slowest on a good file, verify of a biped, takes 3

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


def campaign(
    bad: Iterable[Bad],
    good: Path,
    folder: Path,
    commands: Iterable[str] = COMMANDS,
    unmade: list[str] | None = None,
) -> Iterator[tuple[Bad, Iterator[Run]]]:
    """Make each file in the folder, with the runs of each command on it, to be gone through before the next file.

    bad: the files to be made.
    good: a good result, to compare with.
    folder: to work in.
    commands: names in COMMANDS.
    unmade: gets the names of files that cannot be made, as a text of 64 kB in an old attribute.
    """
    (folder / "tiny.yaml").write_text(TINY)
    for own in bad:
        path = folder / "bad.h5"
        _remove(path)
        shutil.copy(own.source, path)
        try:
            own.damage(path)
        except (RuntimeError, ValueError, TypeError, KeyError, OSError, IndexError):
            if unmade is not None:
                unmade.append(own.name)
            continue
        yield own, (_run(name, own.name, good, folder) for name in commands)


def _remove(path: Path) -> None:
    if path.is_dir() and not path.is_symlink():
        shutil.rmtree(path)
    else:
        path.unlink(missing_ok=True)


def _run(name: str, bad: str, good: Path, folder: Path) -> Run:
    spelt = {"FILE": "bad.h5", "GOOD": str(good)}
    arguments = [spelt.get(word, word) for word in COMMANDS[name]]
    return alone(bad, name, folder, lambda: _read(arguments[0]) if name == "read" else typed(arguments), PROCESSOR)


def _read(path: str) -> int:
    import trajopt

    try:
        trajopt.read(path)
    except TrajoptError as error:
        print(f"error: {error}", file=sys.stderr)
        return 3
    return 0
