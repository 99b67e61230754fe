"""Repeated structure, `for: i in 1..20`, written out in the data of a file before anything else looks at them.

An entry of a mapping or an item of a list that has a key `for` stands for one entry for each value of its variables;
`{i}` in its key and in all texts of it is the value, also `{i + 1}`, `{2*N - i}`. A key `for i in 1..20` holds several
entries repeated together. `sum(i in 1..20, x{i}**2)` in a text is a sum of terms. Whatever is made has the line
of its template, so that mistakes in it are told there.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import islice
from typing import Any, NamedTuple

from ..expressions.slips import MAX_LENGTH
from ..text import brief
from ..yaml.document import MAX_NODES, Path
from ..yaml.locations import Finding
from .ranges import BRACES, MOST, NAME, Mistaken, Values, braces_filled, pairs, whole_numbers
from .templates import OfTemplates, Repeat

FOR = "for"
_KEY = re.compile(r"for\s+(\S.*)")
_SUM = re.compile(r"\bsum\s*\(\s*([A-Za-z]\w*\s+in\s+)")


class Expanded(NamedTuple):
    """data: without templates. lines: path -> line of what it was made of. findings: mistakes in templates. counted:
    parameters that templates go by. of_templates: says of a template what is found of all that it made."""

    data: dict[str, Any]
    lines: dict[Path, int]
    findings: Sequence[Finding] = ()
    counted: frozenset[str] = frozenset()
    of_templates: Callable[[list[Finding]], list[Finding]] = list


def has_loops(node: Any) -> bool:
    """Whether there is a template, or a sum, anywhere in plain data."""
    if isinstance(node, str):
        return _SUM.search(node) is not None
    if isinstance(node, list):
        return any(map(has_loops, node))
    if isinstance(node, dict):
        inside = (_KEY.fullmatch(str(key)) or has_loops(value) for key, value in node.items())
        return _is_template(node) or any(inside)
    return False


def templates_written_out(data: Mapping[str, Any], lines: Mapping[Path, int]) -> Expanded:
    """The data of a file with all templates written out.

    data: as the file has them, overridden parameters in them.
    lines: path of each key and item -> its line.
    """
    expander = _Expander(lines, whole_numbers(data.get("parameters")))
    new = expander.mapping(data, (), (), {})
    texts = " ".join(_texts(data))
    counted = expander.numbers.keys() & {*NAME.findall(texts)}
    told = OfTemplates(expander.repeats, expander.filled)
    return Expanded(new, {**lines, **expander.lines}, expander.findings, frozenset(counted), told)


def _texts(node: Any) -> Iterator[str]:
    """What loops go over, and what stands in braces, anywhere in plain data."""
    if isinstance(node, str):
        yield from BRACES.findall(node)
        yield from (node[found.start() :] for found in _SUM.finditer(node))
    elif isinstance(node, list):
        for item in node:
            yield from _texts(item)
    elif isinstance(node, dict):
        yield str(node[FOR]) if _is_template(node) else ""
        for key, value in node.items():
            yield key if _KEY.fullmatch(key) else " ".join(BRACES.findall(key))
            yield from _texts(value)


class _Expander:
    """One expansion: `old` paths are those of templates, `new` ones those of what they make."""

    def __init__(self, lines: Mapping[Path, int], numbers: Values):
        self.known, self.numbers = lines, numbers
        self.lines: dict[Path, int] = {}
        self.findings: list[Finding] = []
        self.made = 0
        self.repeats: dict[Path, Repeat] = {}

    def value(self, node: Any, old: Path, new: Path, values: Values) -> Any:
        if values:
            self.repeats[new] = Repeat(old, values, node if isinstance(node, str) else "")
        if isinstance(node, str):
            return self._or_told(old, "0" if _SUM.search(node) else node, lambda: self._text(node, values))
        if isinstance(node, list):
            return self.sequence(node, old, new, values)
        if isinstance(node, dict) and len(node) == 1 and set(node) <= values.keys() and set(node.values()) == {None}:
            return values[next(iter(node))]  # {i}, which YAML takes for a mapping
        return self.mapping(node, old, new, values) if isinstance(node, dict) else node

    def mapping(self, node: Mapping[str, Any], old: Path, new: Path, values: Values) -> dict[str, Any]:
        entries: dict[str, Any] = {}
        for key, value in node.items():
            place = (*old, key)
            for at in self._at_each(value, place, values):
                self._entry(entries, key, value, place, new, at)
            if (together := _KEY.fullmatch(key)) is None:
                continue
            entries.pop(key, None)
            body = value if isinstance(value, dict) else {}
            for at in self._loop([together[1]], place, values):
                for inner, own in body.items():
                    for nested in self._at_each(own, (*place, inner), at):
                        self._entry(entries, inner, own, (*place, inner), new, nested)
        return entries

    def sequence(self, node: list[Any], old: Path, new: Path, values: Values) -> list[Any]:
        items: list[Any] = []
        for i, item in enumerate(node):
            place = (*old, i)
            for at in self._at_each(item, place, values):
                here = (*new, len(items))
                self._told_at(here, place)
                items.append(self.value(_without_for(item), place, here, at))
        return items

    def _entry(self, entries: dict[str, Any], key: str, value: Any, place: Path, new: Path, at: Values) -> None:
        name = self._or_told(place, key, lambda: braces_filled(key, at, self.numbers)) if at else key
        if name in entries:
            fault = f'"{brief(name)}" is made more than once' if name != key else f'"{brief(key)}" is the same for all'
            self.findings.append(Finding(place, fault, "write the variable in braces in its key: x{i}"))
            return
        here = (*new, name)
        self._told_at(here, place)
        entries[name] = self.value(_without_for(value), place, here, at)

    def filled(self, text: str, values: Values) -> str:
        """A text as it was made; of a mistaken one, of which is told, nothing."""
        try:
            return braces_filled(text, values, self.numbers)
        except Mistaken:
            return ""

    def _told_at(self, new: Path, old: Path) -> None:
        self.made += 1
        if new != old and old in self.known:
            self.lines[new] = self.known[old]

    def _at_each(self, value: Any, place: Path, values: Values) -> Iterator[Values]:
        """The values of the variables at each repetition of an entry; once for one that is no template."""
        if not _is_template(value):
            yield values
            return
        loops = value[FOR] if isinstance(value[FOR], list) else [value[FOR]]
        yield from self._loop(loops, (*place, FOR), values)

    def _loop(self, loops: list[Any], place: Path, values: Values) -> list[Values]:
        found: list[Values] = [values]
        for loop in loops:
            found = self._or_told(place, [], lambda loop=loop, so_far=found: self._each(loop, so_far))
        return found

    def _each(self, loop: Any, so_far: list[Values]) -> list[Values]:
        most = min(MOST, MAX_NODES - self.made)
        made = ({**own, name: value} for own in so_far for name, value in pairs(loop, own, self.numbers))
        found: list[Values] = list(islice(made, most + 1))  # two long ranges would take all memory
        if len(found) > most:
            raise Mistaken(f"this makes more than {MOST} entries", "write a shorter range")
        return found

    def _text(self, text: str, values: Values) -> str:
        """A text of a template, or one with sums, whose braces may hold the variables of these."""
        if not _SUM.search(text):
            return braces_filled(text, values, self.numbers) if values else text
        text = braces_filled(text, values, self.numbers, of_all=False)
        while found := _SUM.search(text):  # the outermost first: the range of an inner one may depend on its variable
            stop, comma = _closing(text, found.end())
            loop, term = text[found.start(1) : comma], text[comma + 1 : stop].strip()
            terms = [f"({braces_filled(term, at, self.numbers, of_all=False)})" for at in self._each(loop, [{}])]
            text = f"{text[: found.start()]}({' + '.join(terms) or '0'}){text[stop + 1 :]}"
            if len(text) > MAX_LENGTH:
                what = f"written out, this sum has more than {MAX_LENGTH} characters"
                raise Mistaken(what, "name its terms under expressions:, or make the range shorter")
        return braces_filled(text, values, self.numbers)

    def _or_told(self, place: Path, default: Any, work: Any) -> Any:
        try:
            return work()
        except Mistaken as mistake:
            self.findings.append(Finding(place, mistake.what, mistake.remedy))
            return default


def _is_template(value: Any) -> bool:
    """Whether a value says what it is repeated for; a mapping there is something with the name "for"."""
    return isinstance(value, dict) and FOR in value and not isinstance(value[FOR], dict)


def _without_for(value: Any) -> Any:
    return {key: own for key, own in value.items() if key != FOR} if _is_template(value) else value


def _closing(text: str, start: int) -> tuple[int, int]:
    """Where the parenthesis of a sum closes, and the comma after its range; start: where its range begins."""
    depth, comma = 1, -1
    for i in range(start, len(text)):
        depth += (text[i] in "([") - (text[i] in ")]")
        if depth == 0:
            if comma < 0:
                break
            return i, comma
        if depth == 1 and text[i] == "," and comma < 0:
            comma = i
    raise Mistaken(f'the sum "{brief(text[start:])}" is not complete', "write sum(i in 1..20, x{i}**2)")
