"""The page that shows what `trajopt reproduce` made: plain HTML that needs no network, only the figures beside it."""

from __future__ import annotations

import math
import os
import platform
from collections.abc import Iterable, Iterator, Sequence
from datetime import datetime
from html import escape
from importlib.metadata import version

from .chapter import Chapter, PaperCheck

MARK = '<meta name="generator" content="trajopt reproduce">'

STYLE = """
body { max-width: 62rem; margin: 2rem auto; padding: 0 1rem; font: 16px/1.5 sans-serif; color: #111; }
h1, h2, h3 { line-height: 1.2; } h2 { margin-top: 3rem; border-bottom: 1px solid #999; } h3 { font-size: 1rem; }
figure { margin: 2rem 0; } figure img { max-width: 100%; height: auto; } figcaption { max-width: 46rem; }
table { border-collapse: collapse; font-size: 0.9rem; margin: 1rem 0; }
th, td { text-align: left; padding: 0.15rem 0.8rem 0.15rem 0; border-bottom: 1px solid #ddd; vertical-align: top; }
td.number { text-align: right; font-variant-numeric: tabular-nums; }
.fail { color: #b00000; font-weight: bold; }
"""

UNFINISHED = "<p>This run has not come to its end.</p>"


def machine() -> str:
    """What it was measured on, in words."""
    versions = ", ".join(f"{name} {version(name)}" for name in ("trajopt", "pyomo"))
    processor = f"{os.cpu_count()} processors, {platform.machine()}, {platform.system()}"
    return f"{processor}; Python {platform.python_version()}, {versions}"


def shown(number: float) -> str:
    """A number with as many digits as anybody prints; nothing if it is not finite."""
    return f"{number:.9g}" if math.isfinite(number) else ""


def html(chapters: Sequence[Chapter], figures: bool) -> str:
    """The page; one that says so as long as there are no chapters. figures: whether they were drawn."""
    body = "\n".join(_body(chapters, figures)) if chapters else UNFINISHED
    return document("An introduction to trajectory optimization, reproduced", body)


def document(title: str, body: str) -> str:
    """A whole page: a title, and HTML below it."""
    return (
        f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n{MARK}\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f"<title>trajopt reproduce</title>\n<style>{STYLE}</style>\n</head>\n<body>\n"
        f"<h1>{escape(title)}</h1>\n{body}\n</body>\n</html>\n"
    )


def _body(chapters: Sequence[Chapter], figures: bool) -> Iterator[str]:
    checks = [check for chapter in chapters for check in chapter.checks]
    failed = sum(not check.passed for check in checks) + sum(len(chapter.unsolved) for chapter in chapters)
    verdict = f"all {len(checks)} numbers agree" if not failed else f'<span class="fail">{failed} are wrong</span>'
    yield (
        f"<p>The examples and figures of M. Kelly, <i>An Introduction to Trajectory Optimization</i>, SIAM Review "
        f"59(4), 2017, and the driven pendulum of an introduction to direct collocation, computed anew by trajopt. "
        f"Checked: {verdict}. Written on {datetime.now():%Y-%m-%d}, on {escape(machine())}.</p>"
    )
    links = [f'<a href="#{c.example.name}">{escape(c.example.title)}</a>' for c in chapters]
    yield "<p>" + " &middot; ".join([*links, '<a href="#checks">All checks</a>']) + "</p>"
    yield from _efforts(chapters)
    for chapter in chapters:
        yield from _chapter(chapter, figures)
    yield '<h2 id="checks">All checks</h2>'
    yield table(["", "example", "number", "expected", "got", "source"], map(_check, checks), numbers=(4,))


def _efforts(chapters: Sequence[Chapter]) -> Iterator[str]:
    efforts = [effort for chapter in chapters for effort in chapter.efforts]
    if efforts:
        yield "<h2>Iterations and seconds</h2>"
        head = ["", "paper: iterations", "seconds", "here: iterations", "seconds"]
        yield table(head, (map(escape, effort.row) for effort in efforts), numbers=(1, 2, 3, 4))
        yield (
            "<p>The paper: FMINCON on one 3.4 GHz processor, with the derivatives of the biped written by hand. "
            "Here: IPOPT, from the continuous problem to the solution and its error.</p>"
        )


def _chapter(chapter: Chapter, figures: bool) -> Iterator[str]:
    example = chapter.example
    yield f'<h2 id="{example.name}">{escape(example.title)}</h2>'
    for run, message in chapter.unsolved.items():
        yield f'<p class="fail">{escape(run)} was not solved: {escape(message)}</p>'
    if figures and not chapter.unsolved:
        for picture in example.pictures:
            path = f"figures/{picture.file}"
            yield (
                f'<figure id="{picture.file}">\n<h3>{escape(picture.title)}</h3>\n<a href="{path}.pdf">'
                f'<img src="{path}.png" alt="{escape(picture.title)}" loading="lazy"></a>\n'
                f"<figcaption>{escape(chapter.captions[picture.file])}</figcaption>\n</figure>"
            )
    if chapter.table:
        head, *rows = chapter.table
        yield table(list(map(escape, head)), (map(escape, row) for row in rows), numbers=range(1, len(head)))


def _check(check: PaperCheck) -> list[str]:
    verdict = "pass" if check.passed else '<span class="fail">FAIL</span>'
    texts = check.example, check.value.name, check.value.expected, shown(check.number), check.value.source
    return [verdict, *map(escape, texts)]


def table(head: Sequence[str], rows: Iterable[Iterable[str]], numbers: Sequence[int]) -> str:
    """A table in HTML.

    head: texts above the columns, as HTML.
    rows: of cells, as HTML.
    numbers: the columns whose cells stand at the right.
    """

    def cell(column: int, text: str) -> str:
        return f'<td class="number">{text}</td>' if column in numbers else f"<td>{text}</td>"

    lines = ["<table>", "<tr>" + "".join(f"<th>{text}</th>" for text in head) + "</tr>"]
    lines += ["<tr>" + "".join(cell(i, text) for i, text in enumerate(row)) + "</tr>" for row in rows]
    return "\n".join([*lines, "</table>"])
