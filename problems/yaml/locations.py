"""Findings: mistakes located by their path in the data, until the file and line of that path are known."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import field, replace
from shlex import quote
from typing import Any, NamedTuple

from ..errors import Mistake
from ..lean.records import dataclass
from .document import TAKEN, Path, dotted

MAX_FINDINGS = 100
SEVERAL = 3
_DIGITS = re.compile(r"\d+")


class Finding(NamedTuple):
    """A mistake at a path: `Mistake` without the file; kind: where others ask, one of those below."""

    path: Path
    what: str
    remedy: str
    kind: str = ""


UNUSED, OPEN_TIME, UNKNOWN_KEY = "unused", "open time", "unknown key"
"""Kinds of findings: a name that nothing uses, a free time without a guess, and a key that there is not."""


@dataclass(frozen=True)
class Locations:
    """Where each path was given: lines in the file, or an override (path -> its text on the command line).

    blocks: path of a text that goes on below its key -> the lines of the text, each with its number.
    short: path of what was written out from a short form -> the path at which that stands.
    made: path of a component of a vector, before short forms were written out -> that of the vector.
    in_words: puts findings at such paths in the words of the file.
    of_templates: the same of what templates made.
    """

    file: str
    lines: Mapping[Path, int]
    overrides: Mapping[Path, str] = field(default_factory=dict)
    blocks: Mapping[Path, Sequence[tuple[int, str]]] = field(default_factory=dict)
    short: Mapping[Path, Path] = field(default_factory=dict)
    made: Mapping[Path, Path] = field(default_factory=dict)
    in_words: Callable[[list[Finding]], list[Finding]] = list
    of_templates: Callable[[list[Finding]], list[Finding]] = list

    def mistakes(self, findings: Iterable[Finding]) -> tuple[Mistake, ...]:
        """Each finding once, in the order of lines, those of overrides last; not more than a person wants to read.

        Of one text that several components of a vector have, what is said of the first; and so of a line of which the
        same is said of SEVERAL and more, but for numbers: it is that of a loop.
        """
        first: dict[Path, Path] = {}
        longer = [own._replace(path=_of(self.short, own.path)) for own in findings]
        paths = [(finding, _of(self.made, finding.path)) for finding in self.in_words(longer)]
        written = [own._replace(path=path) for own, path in paths if first.setdefault(path, own.path) == own.path]
        once = {(own.path, own.what): own for own in reversed([*self.of_templates(written)])}
        ordered = self._of_loops(sorted(reversed(once.values()), key=lambda finding: self._line(finding.path)))
        located = [
            Mistake(self._where(f.path, f.what, f.kind), f.what, self._remedy(f)) for f in ordered[:MAX_FINDINGS]
        ]
        if len(ordered) > MAX_FINDINGS:
            located.append(Mistake(self.file, "there are more mistakes like these", "mend these first"))
        return tuple(located)

    def _of_loops(self, findings: Sequence[Finding]) -> list[Finding]:
        """The findings, with the first of those that differ by numbers only in place of all."""
        alike: dict[Any, list[Finding]] = {}
        for own in findings:
            words = _DIGITS.sub("#", f"{dotted(own.path)} {own.what} {own.remedy}")
            alike.setdefault((self._line(own.path), words), []).append(own)
        found: list[Finding] = []
        for first, *others in alike.values():
            few = len(others) < SEVERAL - 1
            what = f"{first.what}, and so are {len(others)} more of this line"
            found += [first, *others] if few else [first._replace(what=what)]
        return found

    def overridden(self, path: Path) -> bool:
        """Whether the value at a path was given on the command line."""
        return isinstance(self._origin(path), str)

    def known(self, path: Path) -> bool:
        path = self.as_written(path)
        return path in self.lines or path in self.overrides

    def as_written(self, path: Path) -> Path:
        """A path in the file as it was written, short forms and all."""
        return _of(self.made, _of(self.short, path))

    def written_out(self, path: Path) -> Path:
        """What a path in the file has become; the inverse of `as_written`."""
        made = {written: own for own, written in self.short.items()}
        for n in range(len(path), 0, -1):
            if path[:n] in made:
                return (*made[path[:n]], *path[n:])
        return path

    def locate(self, mistakes: Iterable[Mistake]) -> list[Mistake]:
        """Mistakes whose `where` is a path such as solver.max_iter, with the file and line of that path."""
        located = []
        for mistake in mistakes:
            path = tuple(int(step) if step.isdigit() else step for step in mistake.where.split("."))
            located.append(replace(mistake, where=self._where(self.as_written(path), mistake.what)))
        return located

    def _origin(self, path: Path) -> int | str:
        """The override, or the line, of the longest part of the path that was given.

        An override takes the place of all that the file says there and below.
        """
        parts = [path[:n] for n in range(len(path), 0, -1)]
        for given in (self.overrides, self.lines):
            for part in parts:
                if part in given:
                    return given[part]
                if part == path and given is self.overrides:
                    # the value of a long form, of which the path is told without value:, or a key that is lacking
                    inner = ((*part, key) for key in ("value", TAKEN) if (*part, key) in given)
                    if (own := next(inner, None)) is not None:
                        return given[own]
        return 1

    def _line(self, path: Path) -> tuple[float, int]:
        """The line of a path; that of an override is beyond all, in the order in which they were given."""
        origin = self._origin(path)
        if isinstance(origin, int):
            return origin, 0
        return float("inf"), list(self.overrides.values()).index(origin)

    def _where(self, path: Path, what: str, kind: str = "") -> str:
        origin = self._origin(path)
        if isinstance(origin, str):
            return f"--set {origin}"
        if path and path[-1] in ("value", "expression", "velocity") and not self.known(path):
            # the long form of a value that the file gives in short
            path = path[:-1]
        in_block = path in self.blocks and kind != UNKNOWN_KEY
        line = _line_in(self.blocks[path], what, origin) if in_block else origin
        return f"{self.file}:{line}: {dotted(path)}" if path else f"{self.file}:{line}"

    def _remedy(self, finding: Finding) -> str:
        """What to do; a line to write is an override where the value was given by one."""
        origin = self._origin(finding.path)
        if isinstance(origin, int):
            return finding.remedy
        before, line, value = finding.remedy.partition(f"write {origin.rpartition('.')[2]}: ")
        if before or not line:
            return finding.remedy
        return f"write --set {quote(f'{origin}={value}') if value.startswith('{') else f'{origin}={value}'}"


def _of(origins: Mapping[Path, Path], path: Path) -> Path:
    """A path, with its longest part that was made of another replaced by that."""
    given = next((n for n in range(len(path), 0, -1) if path[:n] in origins), 0)
    return (*origins[path[:given]], *path[given:]) if given else path


def _line_in(block: Sequence[tuple[int, str]], what: str, otherwise: int) -> int:
    """The line of a text that holds what a mistake quotes first; else the first of the text itself."""
    quoted = re.search(r'"([^"]+)"', what)
    piece = re.compile(rf"(?<!\w){re.escape(quoted[1])}(?!\w)" if quoted else r"$^")
    within = [number for number, line in block if piece.search(line)]
    written = [number for number, line in block if line.strip()]
    return (within or written or [otherwise])[0]
