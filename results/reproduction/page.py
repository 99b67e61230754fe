"""The page that shows what `trajopt reproduce` made: it needs no network, only the figures beside it."""

from __future__ import annotations

import math
import platform
from collections.abc import Mapping, Sequence
from datetime import datetime

from ...problems.lean.versions import version
from ..installation import processors
from ..report.page import rendered
from .chapter import Chapter, PaperCheck

MADE_BY = "trajopt reproduce"
MARK = f'<meta name="generator" content="{MADE_BY}">'


def machine() -> str:
    """What it was measured on, in words."""
    versions = ", ".join(f"{name} {version(name)}" for name in ("trajopt", "pyomo"))
    processor = f"{processors()} processors, {platform.machine()}, {platform.system()}"
    return f"{processor}; Python {platform.python_version()}, {versions}"


def shown_number(number: float) -> str:
    """A number with as many digits as anybody prints; nothing if it is not finite."""
    return f"{number:.9g}" if math.isfinite(number) else ""


def html(chapters: Sequence[Chapter], sizes: Mapping[str, tuple[int, int]] | None) -> str:
    """The page; one that says so as long as there are no chapters.

    chapters: one for each example.
    sizes: width and height of each figure by its name, so that nothing moves when it is loaded; None if none is drawn.
    """
    checks = [check for chapter in chapters for check in chapter.checks]
    unsolved = sum(len(chapter.unsolved) for chapter in chapters)
    return rendered(
        "reproduction.html",
        title=MADE_BY,
        made_by=MADE_BY,
        heading="An introduction to trajectory optimization, reproduced",
        chapters=chapters,
        checks=list(map(_check, checks)),
        failed=sum(not check.passed for check in checks) + unsolved,
        efforts=[effort.row for chapter in chapters for effort in chapter.efforts],
        figures=sizes is not None,
        sizes=sizes or {},
        date=f"{datetime.now():%Y-%m-%d}",
        machine=machine(),
    )


def _check(check: PaperCheck) -> list[str]:
    verdict = "pass" if check.passed else "FAIL"
    return [
        verdict,
        check.example,
        check.value.name,
        check.value.expected,
        shown_number(check.number),
        check.value.source,
    ]
