"""Slips of punctuation: a comma or a bracket that ends a value in braces, spaces that are none, a brace left open."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from itertools import takewhile
from typing import Any, NamedTuple

import yaml

from ..text import named, shorten

_OPEN, _CLOSED = "([", ")]"
_DIGITS = re.compile(r"\d+")
_RANGE = re.compile(r"[(\[]([^,()\[\]]+),([^,()\[\]]+)[)\]]")
_UNQUOTED = re.compile(r"(\w+):\s+([^\s\"'\[{#](?:(?!,\s*\w+:\s)[^\"'#])*?\[[^\]]*\][^,}\"']*)")
_POWER = re.compile(r"(\w+):\s+([^\s\"'\[{#][^\"'#]*?)\^\{([^}]*)\}")
_ASSIGNED = re.compile(r"\s*([A-Za-z]\w*)('?)\s*=\s*([^=\s].*?)\s*")
_NO_ENTRY = re.compile(r"(?:[^:#]|:(?=\S))*[^\s:#](?:[^:#]|:(?=\S))*")
_GLUED = re.compile(r"\s*([A-Za-z]\w*):(\S.*)")
_KEY_ALONE = re.compile(r"\s*[\w-]+\s*")

MARKED = re.compile("[\u00a0\u1680\u2000-\u200f\u2028-\u202f\u205f-\u2064\u3000\ufeff]")
"""Spaces that YAML takes for letters, and characters without a width."""


_MARKED_ENTRY = re.compile(rf"[ \t]*(?:\w+:)?[ \t]*({MARKED.pattern})")


class Slip(NamedTuple):
    """what: the mistake. remedy: the line as it should be written. value: what was meant."""

    what: str
    remedy: str
    value: Any


def torn(key: str, value: Any, rest: Sequence[tuple[str, bool]]) -> tuple[Slip, int] | None:
    """The slip of a value in braces that a comma has ended, and how many of the keys after it belong to it.

    key, value: as YAML reads them.
    rest: the keys that follow, and whether each has an empty value.
    """
    if value is None and (glued := _GLUED.fullmatch(key)):
        return Slip("a colon needs a space after it", f"write {glued[1]}: {glued[2]}", None), 0
    parts = [key for key, _ in takewhile(lambda own: own[1], rest)]
    if not parts:
        return None
    if isinstance(value, int) and not isinstance(value, bool) and _DIGITS.fullmatch(parts[0]):
        return Slip(*comma_in_number(key, str(value), parts[0]), float(f"{value}.{parts[0]}")), 1
    return _joined(key, value, parts) if isinstance(value, str) else None


def comma_in_number(key: str, whole: str, digits: str) -> tuple[str, str]:
    """What is said of 1,5, whose comma is a point, and of 1,000, whose comma may be one between thousands.

    key: of the number.
    whole, digits: what stands before the comma, and after it.
    """
    if len(digits) != 3 or whole.lstrip("+-") == "0":
        return "a number has a point, not a comma", f"write {key}: {whole}.{digits}"
    return "there is no comma in a number", f"write {key}: {whole}{digits}, or {whole}.{digits} if it is a point"


def ends_of_range(text: str) -> tuple[str, str] | None:
    """The two ends of a range in parentheses or brackets: (0, 1).

    text: that may be one.
    """
    found = _RANGE.fullmatch(text.strip())
    return (found[1].strip(), found[2].strip()) if found else None


def no_key(before: str, text: str, line: int) -> tuple[str, str]:
    """What is said of a list or a mapping in the place of a key: a comma may have ended the value before it.

    before: the key before it.
    text: of the file.
    line: of what is no key, from 1.
    """
    lines = text.splitlines()
    written = lines[line - 1] if line <= len(lines) else ""
    if before and (found := re.search(rf"(?<!\w){re.escape(before)}:\s+([^\s\"'\[{{].*)", written)):
        ends = (n for n, letter in enumerate(found[1]) if letter in ",}" and _depth(found[1][:n]) == 0)
        value = found[1][: next(ends, None)].rstrip()
        if "," in value and _depth(value) == 0:
            return "a comma ends a value in braces", f'put it in quotes: {before}: "{shorten(value, 120)}"'
    return "a key must be a word", "put the key in quotes, or write key: value"


def _joined(key: str, value: str, parts: Sequence[str]) -> tuple[Slip, int] | None:
    """The value whose brackets close in one of the parts."""
    text = value
    for used, part in enumerate(parts, 1):
        if _depth(text) <= 0:
            break
        text = f"{text}, {part}"
        if _depth(text) == 0:
            if key in ("initial", "final") and (ends := ends_of_range(text)):
                return Slip("a range is no list", f"write {key}: {{lower: {ends[0]}, upper: {ends[1]}}}", None), used
            what = f'a comma ends a value in braces, so this one ends after "{shorten(value, 40)}"'
            return Slip(what, f'put it in quotes: {key}: "{shorten(text, 120)}"', text), used
    return None


def _depth(text: str) -> int:
    """How many brackets are open at the end of a text."""
    return sum((letter in _OPEN) - (letter in _CLOSED) for letter in text)


def strange(key: str) -> str | None:
    """The first character of a key that looks like a space and is none."""
    found = MARKED.search(key)
    return found[0] if found else None


def slips_of(problem: str, mark: yaml.Mark, lines: Sequence[str]) -> Iterator[tuple[int, str, str]]:
    """What a person has done where YAML cannot be read: (index of the line, what, remedy), the likeliest first.

    problem: in PyYAML's words.
    mark: where it stopped.
    lines: of the text.
    """
    number = min(mark.line, len(lines) - 1)
    line = lines[number] if lines else ""
    indent = line[: len(line) - len(line.lstrip())]
    if "\t" in indent:
        yield number, "a tab in the indentation", "indent with spaces, not with tabs"
    if marked := next(((i, found) for i in range(number, -1, -1) if (found := _MARKED_ENTRY.match(lines[i]))), None):
        yield marked[0], f"a character that looks like a space, {named(marked[1][1])}", "write plain spaces"
    if power := _POWER.search(line):
        remedy = f"write ** for a power: {power[1]}: {power[2].strip()}**{power[3]}"
        yield number, "braces in a value, and ^ is no power", remedy
    if unquoted := _UNQUOTED.search(line):
        value = unquoted[2].strip()
        yield number, "a bracket in a value that stands in braces", f'put it in quotes: {unquoted[1]}: "{value}"'
    if "',' or '}'" in problem and _KEY_ALONE.fullmatch(line[: mark.column]) and number:
        before = max((i for i in range(number) if lines[i].strip()), default=0)
        if lines[before].count("{") > lines[before].count("}"):
            yield before, "a brace that is not closed on its line", f"close it: {shorten(lines[before].strip(), 80)}}}"
    if "mapping values are not allowed" in problem and (assigned := _ASSIGNED.fullmatch(line)):
        yield number, "an entry has a colon, not =", f"write {assigned[1]}{assigned[2]}: {shorten(assigned[3], 80)}"
    if "could not find expected ':'" in problem:
        yield from _without_colon(mark.line, lines)
    if "mapping values are not allowed" in problem and number and _ASSIGNED.fullmatch(lines[number - 1]):
        yield from _without_colon(number - 1, lines)


def _without_colon(last: int, lines: Sequence[str]) -> Iterator[tuple[int, str, str]]:
    """The line before, which is no entry."""
    entries = [i for i in range(min(last + 1, len(lines))) if _NO_ENTRY.fullmatch(lines[i])]
    if not entries:
        return
    number = entries[-1]
    if glued := _GLUED.fullmatch(lines[number]):
        yield number, "a colon needs a space after it", f"write {glued[1]}: {glued[2]}"
        return
    if assigned := _ASSIGNED.fullmatch(lines[number]):
        name, prime, value = assigned.groups()
        rate = re.fullmatch(r"(\w+?)_?dot|d(\w+?)_?dt", name)
        state = name if prime else next(filter(None, rate.groups())) if rate else None
        told = f"{state}: {{rate: {value}}}" if state else f"{name}: {value}"
        yield number, "an entry has a colon, not =", f"write {told}"
    else:
        yield number, "an entry without a colon", "write each entry as key: value, and indent keys of one mapping alike"
