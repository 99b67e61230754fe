"""YAML text -> plain data, with the line of every key and every list item.

The text is read as a stream of events, so that its depth and size are checked before anything is built: a file with
nested aliases or ten thousand brackets is refused in no time. Plain scalars follow YAML 1.2: 1e-8 is a number, yes
and on are words, 010 is ten. Tags are refused, so a file can only ever become numbers, strings, lists and mappings.
"""

from __future__ import annotations

import copy
import re
from collections.abc import Iterator
from dataclasses import field, replace
from functools import lru_cache
from typing import Any, NoReturn

import yaml

from ..errors import Mistake, SpecError
from ..lean.records import dataclass
from ..text import brief, named
from .punctuation import no_key, strange, torn
from .unreadable import MAX_LEVELS, TOO_DEEP, unreadable

MAX_BYTES = 1_000_000
MAX_NODES = 300_000
MAX_ALIASES = 100
TAKEN = ""  # stands in a path for a key that an override has taken away
MAX_TORN = 50  # pieces of one value in braces

Path = tuple[str | int, ...]

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
_INTEGER = re.compile(r"[-+]?[0-9]{1,18}")
_FLOAT = re.compile(r"[-+]?(\.[0-9]+|[0-9]+(\.[0-9]*)?)([eE][-+]?[0-9]+)?")
_WORDS: dict[str, Any] = {
    **dict.fromkeys(("", "~", "null", "Null", "NULL"), None),
    **dict.fromkeys(("true", "True", "TRUE"), True),
    **dict.fromkeys(("false", "False", "FALSE"), False),
    **dict.fromkeys((".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"), float("inf")),
    **dict.fromkeys(("-.inf", "-.Inf", "-.INF"), float("-inf")),
    **dict.fromkeys((".nan", ".NaN", ".NAN"), float("nan")),
}
_NOT_TEXT = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\x7f\ufffe\uffff]")


@dataclass
class Document:
    """data: the file as dicts, lists, strings, numbers, bools and None. lines: path of a key or an item -> its line.

    blocks: path of a text that goes on below its key -> the lines of the text, each with its number.
    """

    data: dict[str, Any]
    lines: dict[Path, int] = field(default_factory=dict)
    blocks: dict[Path, list[tuple[int, str]]] = field(default_factory=dict)


def decode(content: bytes, file: str) -> str:
    """The text of a file's content. Raises SpecError if it is not UTF-8 text of a sensible size."""
    if len(content) > MAX_BYTES:
        raise SpecError(Mistake(file, f"the file is larger than {MAX_BYTES // 10**6} MB", "give a problem file"))
    try:
        text = content.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        line = content.count(b"\n", 0, error.start) + 1
        raise SpecError(Mistake(f"{file}:{line}", "this is not UTF-8 text", "save the file as UTF-8")) from error
    if junk := _NOT_TEXT.search(text):
        line = text.count("\n", 0, junk.start()) + 1
        what = f"the file holds the control character {junk[0]!r}, so it is not a text file"
        raise SpecError(Mistake(f"{file}:{line}", what, "give a YAML problem file"))
    return text


def read_document(text: str, file: str) -> Document:
    """The one mapping that the text holds. Raises SpecError; `file` is the name used in its messages."""
    known = _read(text, file)
    return Document(_copied(known.data), known.lines, known.blocks)


def _copied(value: Any) -> Any:
    """Data of a document that share no mapping or list with it."""
    if isinstance(value, dict):
        return {key: _copied(own) for key, own in value.items()}
    return [_copied(own) for own in value] if isinstance(value, list) else value


@lru_cache(maxsize=1)
def _read(text: str, file: str) -> Document:
    """What a text holds; the last is kept, as the cases of a sweep are of one text."""
    data, composer = _compose(text, file)
    if data is None:
        raise SpecError(Mistake(file, "the file is empty", "start from an example: trajopt init NAME"))
    if not isinstance(data, dict):
        what = f"the file holds {in_words(data)}, not a mapping"
        raise SpecError(Mistake(f"{file}:1", what, "write keys such as name: and states: at its left margin"))
    written = dict(enumerate(text.splitlines()))
    blocks = {path: [(n + 1, written.get(n, "")) for n in lines] for path, lines in composer.blocks.items()}
    return Document(data, composer.lines, blocks)


def _compose(text: str, file: str) -> tuple[Any, _Composer]:
    composer = _Composer(_told(yaml.parse(text, Loader=_LOADER)), file, text)
    try:
        data = composer.document()
    except yaml.YAMLError as error:
        last = unreadable(error, text, file, composer.line)
        told = {own.where for own in composer.mistakes}  # as of a character that makes a line unreadable, too
        raise SpecError([*composer.mistakes, *([] if last.where in told else [last])]) from error
    if composer.mistakes:
        raise SpecError(composer.mistakes)
    return data, composer


def _told(events: Iterator[yaml.Event]) -> Iterator[yaml.Event]:
    """The events, where whatever else the library raises is an error of the text too: its releases differ in that."""
    try:
        yield from events
    except yaml.YAMLError:
        raise
    except Exception as error:
        raise yaml.YAMLError(f"{type(error).__name__}: {error}") from error


def value_of(text: str, where: str) -> Any:
    """The value that a piece of YAML on the command line means. Raises SpecError at `where`."""
    try:
        return _compose(text, where)[0]
    except SpecError as error:
        # a line number means nothing on the command line
        raise SpecError(replace(mistake, where=where) for mistake in error.mistakes) from error


def scalar(text: str) -> Any:
    """A plain scalar as a number, bool, None or string."""
    if text in _WORDS:
        return _WORDS[text]
    if _INTEGER.fullmatch(text):
        return int(text)
    return float(text) if _FLOAT.fullmatch(text) else text


def in_words(value: Any) -> str:
    """What a value is, in words, for messages."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, int | float):
        return f"the number {value:g}"
    if isinstance(value, str):
        return f'the text "{brief(value)}"'
    if isinstance(value, dict):
        return "a mapping"
    return "a list" if isinstance(value, list) else "nothing"


def dotted(path: Path) -> str:
    """A path as the user writes it: mesh.0.segments."""
    return ".".join(map(brief, path))


def _line(event: yaml.Event) -> int:
    """The line of an event of the file, from 1."""
    return event.start_mark.line + 1 if event.start_mark else 1


class _Composer:
    """Builds the data while the events come in; `mistakes` holds those that do not stop it."""

    def __init__(self, events: Iterator[yaml.Event], file: str, text: str):
        self.events, self.file, self.text = events, file, text
        self.lines: dict[Path, int] = {}
        self.blocks: dict[Path, range] = {}
        self.mistakes: list[Mistake] = []
        self.anchors: dict[str, tuple[Any, int]] = {}
        self.nodes = self.aliases = 0
        self.line = 1  # of the last value

    def document(self) -> Any:
        data, documents = None, 0
        for event in self.events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    self.stop(event, "a second document starts here (---)", "keep one problem in a file")
                data = self.node(next(self.events), ())
        return data

    def node(self, event: yaml.Event, path: Path) -> Any:
        """The value that starts with this event."""
        self.check_event(event, path)
        if isinstance(event, yaml.AliasEvent):
            return self.alias(event)
        before = self.nodes
        if isinstance(event, yaml.ScalarEvent):
            value = scalar(event.value) if event.implicit[0] else event.value
            if isinstance(value, str) and event.end_mark and event.end_mark.line >= self.lines.get(path, self.line):
                end = event.end_mark  # | and > have no text on their first line
                self.blocks[path] = range(self.line - (event.style not in ("|", ">")), end.line + (end.column > 0))
        elif isinstance(event, yaml.SequenceStartEvent):
            value = self.sequence(path)
        else:
            value = self.mapping(path, in_braces=bool(getattr(event, "flow_style", False)))
        if isinstance(event, yaml.NodeEvent) and event.anchor is not None:
            self.anchors[event.anchor] = value, self.nodes - before + 1
        return value

    def sequence(self, path: Path) -> list[Any]:
        items: list[Any] = []
        while not isinstance(event := next(self.events), yaml.SequenceEndEvent):
            here = (*path, len(items))
            self.lines[here] = _line(event)
            items.append(self.node(event, here))
        return items

    def mapping(self, path: Path, in_braces: bool) -> dict[str, Any]:
        found: list[tuple[str, int, Any]] = []
        while not isinstance(event := next(self.events), yaml.MappingEndEvent):
            if not isinstance(event, yaml.ScalarEvent):
                self.stop(event, *no_key(found[-1][0] if found else "", self.text, _line(event)))
            self.check_event(event, path)
            here = (*path, event.value)
            line = _line(event)
            if character := strange(event.value):
                what = f"the key holds a character that is no plain space, {named(character)}"
                self.mistakes.append(Mistake(f"{self.file}:{line}", what, "write plain spaces in its place"))
            self.lines.setdefault(here, line)
            found.append((event.value, line, self.node(next(self.events), here)))
        return self.entries(self.whole(found, path) if in_braces else found, path)

    def whole(self, found: list[tuple[str, int, Any]], path: Path) -> list[tuple[str, int, Any]]:
        """The entries of braces, with those in one that a comma has torn; such a comma is a mistake."""
        rest, kept = found, []
        while rest:
            (key, line, value), *rest = rest
            if slip := torn(key, value, [(other, empty is None) for other, _, empty in rest[:MAX_TORN]]):
                (what, remedy, value), used = slip
                self.mistakes.append(Mistake(f"{self.file}:{line}: {dotted((*path, key))}", what, remedy))
                rest = rest[used:]
            kept.append((key, line, value))
        return kept

    def entries(self, found: list[tuple[str, int, Any]], path: Path) -> dict[str, Any]:
        """The mapping, each key once; a second one is a mistake."""
        entries: dict[str, Any] = {}
        for key, line, value in found:
            if key in entries:
                here = (*path, key)
                what = f"the key is given twice, first on line {self.lines[here]}"
                self.mistakes.append(Mistake(f"{self.file}:{line}: {dotted(here)}", what, "remove one of them"))
                continue
            entries[key] = value
        return entries

    def alias(self, event: yaml.AliasEvent) -> Any:
        anchor = str(event.anchor)
        if anchor not in self.anchors:
            self.stop(event, f"*{brief(anchor)} refers to no anchor", "put a text that starts with * in quotes")
        value, size = self.anchors[anchor]
        self.aliases += 1
        self.nodes += size
        if self.aliases > MAX_ALIASES:
            self.stop(event, f"the file has more than {MAX_ALIASES} aliases", "write the values out")
        self.check_size(event)
        return copy.deepcopy(value)

    def check_event(self, event: yaml.Event, path: Path) -> None:
        self.nodes += 1
        self.line = _line(event)
        self.check_size(event)
        if len(path) > MAX_LEVELS:
            self.stop(event, *TOO_DEEP)
        tag = getattr(event, "tag", None)
        if tag is not None:
            what = f"the tag {brief(tag)} is not allowed"
            self.stop(event, what, "write the plain value, or put the text in quotes")

    def check_size(self, event: yaml.Event) -> None:
        if self.nodes > MAX_NODES:
            self.stop(event, f"the file holds more than {MAX_NODES} values", "remove aliases or shorten its lists")

    def stop(self, event: yaml.Event, what: str, remedy: str) -> NoReturn:
        raise SpecError([*self.mistakes, Mistake(f"{self.file}:{_line(event)}", what, remedy)])
