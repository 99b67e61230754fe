"""The errors a user can cause. Everything else that is raised is a bug of ours and keeps its traceback."""

from __future__ import annotations

from collections.abc import Iterable

from .lean.records import dataclass
from .text import escaped


@dataclass(frozen=True)
class Mistake:
    """One mistake: where it stands, what is wrong, and how to mend it. `str()` gives the one sentence a user reads.

    where: "file.yaml:12: states.q1.rate", "--set mesh.0.segments", or a file name.
    """

    where: str
    what: str
    remedy: str

    def __str__(self) -> str:
        return escaped(f"{self.where}: {self.what}; {self.remedy}")


class TrajoptError(Exception):
    """Base of all errors that are the user's to mend; carries every mistake that was found, not only the first."""

    def __init__(self, mistakes: Mistake | Iterable[Mistake]):
        self.mistakes = (mistakes,) if isinstance(mistakes, Mistake) else tuple(mistakes)
        super().__init__("\n".join(map(str, self.mistakes)))

    def __reduce__(self) -> tuple[type[TrajoptError], tuple[tuple[Mistake, ...]]]:
        return type(self), (self.mistakes,)  # not the text: an error may come from another process


class SpecError(TrajoptError):
    """The problem file, an override, or a command-line value is wrong (exit code 2)."""


class FileError(TrajoptError):
    """A file cannot be read or written (exit code 3)."""
