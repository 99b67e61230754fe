"""What is said of all entries that a template made, said of the template: T{i}, and not T1 to T20."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping
from dataclasses import field
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
    """A value that a template made.

    old: the path of the template. values: of the variables of its loops. words: name that was made -> as the template
    has it. made, written: the text, if it is one.
    """

    old: Path
    values: tuple[tuple[str, int | str], ...]
    words: Mapping[str, str]
    made: str
    written: str


@dataclass(frozen=True)
class OfTemplates:
    """Puts findings in the words of templates; repeats: path of what was made -> what is known of it."""

    repeats: Mapping[Path, Repeat] = field(default_factory=dict)

    def __call__(self, findings: list[Finding]) -> list[Finding]:
        """The findings, with one in place of those that are of all repetitions alike."""
        told: dict[Finding, list[Finding]] = {}
        for own in findings:
            told.setdefault(self._of_all(own), []).append(own)
        new: list[Finding] = []
        for whole, some in told.items():
            count = self._counts[whole.path] or max(
                (self._counts[whole.path[:n]] for n in range(len(whole.path))), default=0
            )
            new += [whole] if len({own.path for own in some}) == count > 1 else some
        return new

    def _of_all(self, own: Finding) -> Finding:
        """What would be said of the template."""
        for n in range(len(own.path), 0, -1):
            if (repeat := self.repeats.get(own.path[:n])) is not None:
                rest = own.path[n:]
                what, remedy = (_in_words(said, repeat) for said in (own.what, own.remedy))
                return Finding((*repeat.old, *rest), what, remedy)
        return own

    @cached_property
    def _counts(self) -> Counter[Path]:
        """How often each template is repeated."""
        return Counter(own.old for own in self.repeats.values())


def _in_words(said: str, repeat: Repeat) -> str:
    said = with_quotes(said, repeat.made, repeat.written)
    return _PLAIN.sub(lambda found: repeat.words.get(found[0], found[0]), said)
