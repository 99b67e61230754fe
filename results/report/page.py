"""A page: a template, what stands in it, and all that it needs to work without a network.

Whatever comes from a result or a problem file is text: Jinja escapes it, and what no screen should be given (control
characters, marks that turn the direction of writing) is written as its escape, \\x1b. Data for scripts are JSON, in
which no tag can end. A policy in the page's head lets nothing run but the scripts that trajopt has put there.
"""

from __future__ import annotations

import json
from base64 import b64encode
from collections.abc import Mapping, Sequence
from functools import cache
from hashlib import sha256
from pathlib import Path
from typing import Any

from ...problems.files import check_ours, check_suffix
from ...problems.lean.versions import version
from ...problems.text import escaped
from ..file.json_values import for_json

HERE = Path(__file__).parent
MARK = "trajopt report"
"""Stands in the head of every page, by which it is known again."""

SUFFIXES = (".html", ".htm")
PLOTS = ("uPlot.iife.min.js", "charts.js")
"""The scripts that draw curves. uPlot 1.6.32: 50 kB under the MIT licence, where plotly.js has 4.5 MB."""

_MARKED = 2000  # bytes, of which the mark is in
_IN_SCRIPT = {ord("<"): "\\u003c", ord(">"): "\\u003e", ord("&"): "\\u0026", 0x2028: "\\u2028", 0x2029: "\\u2029"}


def visible(text: str) -> str:
    """The text with the escape of every character that cannot be seen, but for breaks of lines and tabs."""
    return escaped(text, lambda character: not character.isprintable())


def rendered(template: str, *, title: str, scripts: Sequence[str] = (), made_by: str = MARK, **context: Any) -> str:
    """The page.

    template: its name, in the folder `templates`.
    title: of the page.
    scripts: the names of those it needs, in the folder `assets`.
    made_by: stands in its head as the generator.
    context: what the template shows.
    """
    whole = [_asset(name) for name in scripts]
    return (
        _templates()
        .get_template(template)
        .render(
            title=title,
            styles=[_asset(name) for name in (*(("uPlot.min.css",) if PLOTS[0] in scripts else ()), "page.css")],
            scripts=whole,
            hashes=[b64encode(sha256(script.encode()).digest()).decode() for script in whole],
            licence=_asset("uPlot.LICENSE.txt") if PLOTS[0] in scripts else "",
            made_by=made_by,
            version=version("trajopt"),
            **context,
        )
    )


def check_page(path: Path, force: bool = False) -> None:
    """Refuse, before any work is done, a path that no page could or should be written to.

    path: of the page to come; an earlier page of trajopt's may be replaced.
    force: whether any other file may be replaced too.

    Raises SpecError for another suffix, FileError otherwise.
    """
    check_suffix(path, "page", SUFFIXES, "end the name with .html")
    check_ours(path, force, _ours, f"is no page of '{MARK}'")


def _ours(path: Path) -> bool:
    with path.open("rb") as stream:
        return f'content="{MARK}"'.encode() in stream.read(_MARKED)


@cache
def _asset(name: str) -> str:
    return (HERE / "assets" / name).read_text(encoding="utf-8")


@cache
def _templates() -> Any:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined
    from markupsafe import Markup

    def finalize(value: Any) -> Any:
        return visible(value) if isinstance(value, str) and not isinstance(value, Markup) else value

    def data(value: Any) -> Markup:
        return Markup(json.dumps(_seen(for_json(value)), separators=(",", ":"), allow_nan=False).translate(_IN_SCRIPT))

    environment = Environment(
        autoescape=True,
        loader=FileSystemLoader(HERE / "templates"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=finalize,
    )
    environment.filters["data"] = data
    environment.filters["own"] = Markup  # of trajopt's own files only
    return environment


def _seen(value: Any) -> Any:
    """Plain data with `visible` texts."""
    if isinstance(value, str):
        return visible(value)
    if isinstance(value, Mapping):
        return {visible(key): _seen(item) for key, item in value.items()}
    return [_seen(item) for item in value] if isinstance(value, list) else value
