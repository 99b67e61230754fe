"""A broken file, and the ways to make one."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from .good import GOOD


@dataclass(frozen=True)
class Case:
    """content: the file, or None for a file that cannot be made by writing bytes (see `write`).

    place: what follows the file name in `where`, such as ":12: states.x.rate", or the whole of it if it starts with
    "--set". says: words that must stand in the sentence. kind: "spec" (exit code 2) or "file" (exit code 3).
    """

    name: str
    content: bytes | None
    place: str
    says: str
    overrides: tuple[str, ...] = ()
    kind: str = "spec"


def write(case: Case, folder: Path) -> Path:
    """The file of a case, in an empty folder."""
    path = folder / "broken.yaml"
    if case.content is not None:
        path.write_bytes(case.content)
    elif case.name == "a folder":
        path.mkdir()
    elif case.name == "a dangling link":
        path.symlink_to(folder / "nowhere.yaml")
    return path


def edits(text: str):
    """A function that makes cases from a good file."""

    def edit(name: str, old: str, new: str, path: str, says: str, *, line: int | None = None) -> Case:
        """The file with `old` replaced; the mistake stands on the line where `old` begins unless another is given."""
        assert text.count(old) == 1, f"{old!r} must stand once in the good file"
        line = line or text[: text.index(old)].count("\n") + 1
        place = f":{line}: {path}" if path else f":{line}"
        return Case(name, text.replace(old, new).encode(), place, says)

    return edit


edit = edits(GOOD)


def rate_of_v(name: str, rate: str, says: str) -> Case:
    """The good file with another rate of v."""
    return edit(name, "(u - c*v)/m", f"'{rate.replace(chr(39), chr(39) * 2)}'", "states.v.rate", says)


def override(name: str, setting: str, says: str, place: str | None = None) -> Case:
    """The good file with an override."""
    return Case(name, GOOD.encode(), place or f"--set {setting.partition('=')[0]}", says, (setting,))


def raw(name: str, content: str | bytes, place: str, says: str) -> Case:
    return Case(name, content if isinstance(content, bytes) else content.encode(), place, says)
