"""What is said of the components of vectors, in the words of the file: r[1] and "F/m", where r1 and "F1/m" were made.

What is said of all components of a vector alike is said once, of the vector.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import cached_property
from typing import NamedTuple

from ..lean.records import dataclass
from ..text import shorten
from .document import Path
from .locations import UNUSED, Finding

LONGEST = 120
"""Characters of an expression in a message."""

_NAME = re.compile(r"(?<!\w)[A-Za-z_]\w*")
_LISTED = re.compile(r"(?<!\w)[A-Za-z_]\w*(?:, [A-Za-z_]\w*)+")
_QUOTED = re.compile(r'(\bin )?"([^"]*)"')
_MEANT = re.compile(r"(?<=did you mean )[A-Za-z_]\w*")
_UNKNOWN = re.compile(r'unknown name "([^"]*)"')
_OF_ONE = re.compile(r"(?<!\w)[A-Za-z_]\w*\d\b")
"""A name that may be meant as that of a component."""

Index = tuple[int, ...]


class Made(NamedTuple):
    """One component of what is said at a path.

    base: the path in the file; of what is said as a list, that of the list.
    at: the index of the component. of: how many there are.
    """

    base: Path
    at: Index
    of: int


class Named(NamedTuple):
    """A name that was made: the vector's, and which component it is."""

    vector: str
    at: Index

    def __str__(self) -> str:
        return f"{self.vector}[{', '.join(str(i + 1) for i in self.at)}]"


@dataclass(frozen=True)
class InWords:
    """Puts findings in the words of the file.

    names: of components. made: path that is written -> what it is made of. texts: such a path -> the expression that
    is written there, and that of the file.
    """

    names: Mapping[str, Named] = field(default_factory=dict)
    made: Mapping[Path, Made] = field(default_factory=dict)
    texts: Mapping[Path, tuple[str, str]] = field(default_factory=dict)

    def __call__(self, findings: Sequence[Finding]) -> list[Finding]:
        """The findings, at paths that are written; what is said of all components is at the path in the file."""
        told: dict[Finding, tuple[int, dict[Index, Finding]]] = {}
        for own in self._where_written(findings):
            made, base = self._origin(own.path)
            whole = self._in_words(own, made.at)._replace(path=base)
            told.setdefault(whole, (made.of, {}))[1][made.at] = self._in_words(own, None)
        new: list[Finding] = []
        for whole, (count, singles) in told.items():
            if len(singles) == count > 1:
                new.append(whole)
            elif count == 1 or not _is_unused(whole):  # a vector of which some components are used is used
                new += singles.values()
        return new

    def _where_written(self, findings: Sequence[Finding]) -> list[Finding]:
        """The findings, without those of a name that is unknown in a function of the file, where one only calls it."""
        often = Counter(own.what for own in findings)
        return [own for own in findings if often[own.what] == 1 or not self._only_called(own)]

    def _only_called(self, own: Finding) -> bool:
        unknown, (_, written) = _UNKNOWN.match(own.what), self.texts.get(own.path, ("", ""))
        return bool(unknown and written and not re.search(rf"\b{re.escape(unknown[1])}\b", written))

    def _origin(self, path: Path) -> tuple[Made, Path]:
        """What a path is made of, and its own in the file."""
        for n in range(len(path), 0, -1):
            if (made := self.made.get(path[:n])) is not None:
                return made, (*made.base, *path[n:])
        return Made(path, (), 1), path

    def _in_words(self, own: Finding, index: Index | None) -> Finding:
        """A finding in the words of the file.

        index: of the component that it is about; those of this index are told as their vectors. None for as they are.
        """
        one = _OF_ONE.search(own.what) is not None  # r, and not r[1], for a name that is like r
        remedy = own.remedy if one else _MEANT.sub(lambda found: self._vector(found[0]), own.remedy)
        return own._replace(what=self._text(own.what, own.path, index), remedy=self._text(remedy, own.path, index))

    def _text(self, said: str, path: Path, index: Index | None) -> str:
        made, written = self.texts.get(path, ("", ""))
        said = with_quotes(said, made, written)
        said = _LISTED.sub(lambda found: self._together(found[0].split(", ")), said)
        return _NAME.sub(lambda found: self._name(found[0], index), said)

    def _vector(self, name: str) -> str:
        return self.names[name].vector if name in self.names else name

    def _name(self, name: str, index: Index | None) -> str:
        own = self.names.get(name)
        return name if own is None else own.vector if own.at == index else str(own)

    def _together(self, listed: Sequence[str]) -> str:
        """A list of names, in which all components of a vector are the vector."""
        vectors = Counter(self.names[name].vector for name in listed if name in self.names)
        whole = [vector for vector, count in vectors.items() if count == self.sizes[vector]]
        shown: list[str] = []
        for name in listed:
            own = self.names[name].vector if name in self.names else ""
            if own not in whole:
                shown.append(name)
            elif own not in shown:
                shown.append(own)
        return ", ".join(shown)

    @cached_property
    def sizes(self) -> Counter[str]:
        """How many components each vector has."""
        return Counter(own.vector for own in self.names.values())


def _is_unused(own: Finding) -> bool:
    return own.path[:1] == ("parameters",) and own.kind == UNUSED


def with_quotes(said: str, made: str, written: str) -> str:
    """A sentence with what it quotes of an expression as the file has that.

    said: the sentence.
    made: the expression, which was made of that of the file.
    written: of the file.
    """
    return _QUOTED.sub(lambda found: _quoted(found, made, written), said)


def _quoted(found: re.Match[str], made: str, written: str) -> str:
    """What is quoted of an expression that was made: what the file has, if it is all of it or what is around."""
    inside = found[2].strip(".")
    parts = inside.split(" ... ")
    whole = made.startswith(parts[0]) and made.endswith(parts[-1])
    if made and all(part in made for part in parts) and (found[1] or whole):
        return f'{found[1] or ""}"{shorten(written, LONGEST)}"'
    return found[0]
