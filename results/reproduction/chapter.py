"""What came of one example: its checks, its efforts, and what its page shows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from ...problems.lean.records import dataclass
from .figures.example import Example
from .paper_values import Effort, Value


@dataclass(frozen=True)
class PaperCheck:
    """A number against what it should be."""

    example: str
    value: Value
    number: float

    @property
    def passed(self) -> bool:
        return self.value.holds(self.number)


@dataclass(frozen=True)
class MeasuredEffort:
    """What a solve took, beside what it took in the paper."""

    paper: Effort
    iterations: int
    seconds: float

    @property
    def row(self) -> list[str]:
        """As texts: what, the paper's iterations and seconds, and those measured here."""
        paper = self.paper
        return [paper.what, str(paper.iterations), f"{paper.seconds:g}", str(self.iterations), f"{self.seconds:.3f}"]


@dataclass(frozen=True)
class Chapter:
    """One example, done. unsolved: name of a run -> how it ended. table: rows of texts, the first one of headings."""

    example: Example
    captions: Mapping[str, str]
    checks: tuple[PaperCheck, ...]
    efforts: tuple[MeasuredEffort, ...]
    table: Sequence[Sequence[str]]
    unsolved: Mapping[str, str]

    @property
    def passed(self) -> bool:
        return not self.unsolved and all(check.passed for check in self.checks)
