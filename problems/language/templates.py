"""What is said of all entries that a template made, said of the template: T{i}, and not T1 to T20."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import NamedTuple

from ..lean.records import dataclass
from ..yaml.document import Path
from ..yaml.locations import Finding
from ..yaml.told import with_quotes

WORD = re.compile(r"[A-Za-z_]\w*(?:\{[^{}]*\}\w*)+")
"""A name with variables of loops in it."""
_PLAIN = re.compile(r"(?<!\w)[A-Za-z_]\w*")


class Repeat(NamedTuple):
    """A value that a template made: the path of the template, the variables of its loops, the text, if it is one."""

    old: Path
    values: Mapping[str, int | str]
    written: str


@dataclass(frozen=True)
class OfTemplates:
    """Puts findings in the words of templates.

    repeats: path of what was made -> what it was made of. filled: a text with the values of variables in its braces.
    """

    repeats: Mapping[Path, Repeat]
    filled: Callable[[str, Mapping[str, int | str]], str]

    def __call__(self, findings: list[Finding]) -> list[Finding]:
        """The findings, with one in place of those that are of all repetitions alike."""
        told: dict[tuple[Path, str], list[Finding]] = {}
        for own in findings:
            told.setdefault(self._of_all(own)[:2], []).append(own)  # whatever the remedy: one name may be like another
        new: list[Finding] = []
        for (path, _), some in told.items():
            of_all = len({own.path for own in some}) == self._count(path) > 1
            new += [self._of_all(some[0])] if of_all else some
        return new

    def _count(self, path: Path) -> int:
        """How often what is at a path in a template, or around it, is repeated."""
        return next((own for n in range(len(path), 0, -1) if (own := self._counts[path[:n]])), 0)

    def _of_all(self, own: Finding) -> Finding:
        """What would be said of the template."""
        for n in range(len(own.path), 0, -1):
            if (repeat := self.repeats.get(own.path[:n])) is not None:
                rest = own.path[n:]
                what, remedy = (self._in_words(said, repeat) for said in (own.what, own.remedy))
                return Finding((*repeat.old, *rest), what, remedy)
        return own

    @cached_property
    def _counts(self) -> Counter[Path]:
        """How often each template is repeated."""
        return Counter(own.old for own in self.repeats.values())

    def _in_words(self, said: str, repeat: Repeat) -> str:
        words = WORD.findall(" ".join([repeat.written, *(key for key in repeat.old if isinstance(key, str))]))
        made = {self.filled(word, repeat.values): word for word in words}
        said = with_quotes(said, self.filled(repeat.written, repeat.values), repeat.written)
        return _PLAIN.sub(lambda found: made.get(found[0], found[0]), said)
