"""Overrides from the command line: PATH=VALUE sets one value of the file, before anything is checked."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import yaml

from ..errors import Mistake, SpecError
from ..text import did_you_mean, printable, unprintable
from .document import TAKEN, Document, Path, dotted, in_words, value_of
from .unreadable import MAX_LEVELS

# A new name in these would almost always be a misspelt one, and do nothing.
_NAMED = frozenset(
    {"phases", "parameters", "expressions", "states", "controls", "algebraic", "integrals", "optimize", "tables"}
)
_SECTIONS = frozenset(["time", "objective", "constraints", "guess", "refine", "mesh", "solver", "reference"])
_PLACES = {
    word: path
    for path, words in {
        "mesh.0.segments": "segments intervals nodes n_segments",
        "mesh.*.method": "method scheme transcription",
        "refine.tolerance": "tolerance mesh_tolerance",
        "refine.max_meshes": "max_meshes",
        "solver.tol": "tol",
        "solver.max_iter": "max_iter maxiter max_iterations iterations",
        "solver.seconds": "seconds time_limit timeout",
        "solver.starts": "starts",
        "solver.seed": "seed",
        "solver.engine": "engine",
        "solver.print_level": "print_level",
        "time.final": "tf t_f t_final final final_time duration T",
        "time.initial": "t0 t_0 initial initial_time",
    }.items()
    for word in words.split()
}
"""Word that stands alone in an override -> the path that is meant."""
EXAMPLE = "write --set PATH=VALUE, as --set parameters.u_max=15"
_DECIMAL = re.compile(r"-?\d+(,\d+)?")
_KEYS = {
    "states": "rate, initial, final or lower",
    "controls": "lower or upper",
    "algebraic": "lower or upper",
    "optimize": "lower, upper or guess",
    "tables": "values or outside",
    "phases": "parameters.NAME or time.final",
}
"""Section of names -> what a name in it may have for its value."""
_OF_MODEL = frozenset({"states", "controls", "algebraic"})  # a file with model: need not repeat their names


def override(document: Document, overrides: Sequence[str]) -> tuple[dict[str, Any], dict[Path, str]]:
    """The data with every override applied (in place), and the path of each -> PATH as the user wrote it.

    One that takes a key away has another path beside its own: that of what lacks it, with TAKEN at its end.

    A path is keys and list indices with dots between them: mesh.0.segments, also mesh[0].segments, mesh.-1.tolerance
    and mesh.*.method for all. The value is YAML; an empty one takes the key away. Raises SpecError for a path that
    leads nowhere.
    """
    given: dict[Path, str] = {}
    mistakes: list[Mistake] = []
    for text in overrides:
        shown, equals, value = text.partition("=")
        try:
            if not equals or not shown.strip():
                before, colon, own = text.partition(":")
                remedy = f"write --set {before}={own.strip()}" if colon and own.strip() else EXAMPLE
                raise SpecError(Mistake(f"--set {text}", "this is not PATH=VALUE", remedy))
            if value.startswith("="):
                remedy = f"write --set {shown.strip()}={value.lstrip('= ')}"
                raise SpecError(Mistake(f"--set {shown.strip()}", "there is one = in PATH=VALUE", remedy))
            if any(unprintable(c) and not c.isspace() for c in text):
                what = "it holds what is no text: a control character, or a byte that is not UTF-8"
                raise SpecError(Mistake(f"--set {printable(shown)}", what, "type it again"))
            where = f"--set {shown.strip()}"
            new = value_of(value, where)
            meant = shown.strip()
            _check_section(document.data, meant, value, where)
            for path in [*_paths(document.data, meant, where), *_in_phases(document.data, meant, where)]:
                place = _assign(document.data, path, new, where)
                # what is on the way and not in the file is new as well
                new_ones = (path[:n] for n in range(1, len(path)) if path[:n] not in document.lines)
                taken = [(*place[:-1], TAKEN)] if new is None else []
                given |= dict.fromkeys([*new_ones, place, *taken], shown.strip())
        except SpecError as error:
            mistakes += error.mistakes
    if mistakes:
        raise SpecError(mistakes)
    return document.data, given


def as_text(values: Mapping[str, object]) -> list[str]:
    """Path -> value of Python's as overrides "PATH=VALUE".

    values: numbers, texts, booleans, None, and lists, tuples, dicts and NumPy arrays of them.

    Raises SpecError, at each path, for a value that no problem file can hold.
    """
    texts: list[str] = []
    mistakes: list[Mistake] = []
    for path, value in values.items():
        where = f"--set {path}"
        if not isinstance(path, str) or "=" in path:
            what = "this is not a path"
            mistakes.append(Mistake(where, what, "write keys with dots between them: mesh.0.segments"))
            continue
        try:
            # in a list, so that YAML writes no end of document after a plain value
            listed = yaml.dump([value], Dumper=_Dumper, default_flow_style=True, width=float("inf"), sort_keys=False)
            texts.append(f"{path}={listed.strip()[1:-1]}")
        except (yaml.representer.RepresenterError, RecursionError):
            what = f"a value of type {type(value).__name__} cannot stand in a problem file"
            mistakes.append(Mistake(where, what, "give numbers, texts, lists or dicts"))
    if mistakes:
        raise SpecError(mistakes)
    return texts


class _Dumper(yaml.SafeDumper):
    """Writes every text in quotes, so that "1e5" stays a text, and what NumPy holds as plain numbers and lists."""

    def ignore_aliases(self, data: Any) -> bool:
        return True

    def represent_text(self, text: str) -> yaml.Node:
        return self.represent_scalar("tag:yaml.org,2002:str", text, style='"')

    def represent_plain(self, value: Any) -> yaml.Node:
        plain = getattr(value, "tolist", None)
        return self.represent_data(plain()) if plain else self.represent_undefined(value)


_Dumper.add_representer(str, _Dumper.represent_text)
_Dumper.add_multi_representer(object, _Dumper.represent_plain)


def _paths(data: dict[str, Any], shown: str, where: str) -> Iterator[Path]:
    """The paths that an override names: several with *."""
    steps = shown.replace("[", ".").replace("]", "").split(".")
    if len(steps) > MAX_LEVELS or "" in steps:
        raise SpecError(Mistake(where, "this is not a path", "write keys with dots between them: mesh.0.segments"))
    found: list[tuple[Path, Any]] = [((), data)]
    for step in steps:
        if not (data.get("model") and steps[0] in _OF_MODEL):
            _check_declared(found, step, where)
        found = [((*path, key), _below(node, key)) for path, node in found for key in _keys(node, step, path, where)]
    return (path for path, _ in found)


def _check_section(data: dict[str, Any], shown: str, value: str, where: str) -> None:
    """Refuse a path that leaves out the section of its name: m=2 for parameters.m=2.

    A number of the file has a value; what is to be found has bounds, and ends.
    """
    first, _, rest = shown.partition(".")
    section = _section_of(data, first)
    if section is None:
        if place := _PLACES.get(shown) if first not in data else None:
            raise SpecError(
                Mistake(where, f"{shown} has its place in the file", f"write --set {place}={value.strip()}")
            )
        return
    number = bool(_DECIMAL.fullmatch(value.strip())) and section == "parameters" and not rest
    meant = value.strip().replace(",", ".") if number else value.strip()
    what = f"{first} is one of the {section}"
    if section in ("parameters", "expressions", "integrals") or rest:
        raise SpecError(Mistake(where, what, f"write --set {section}.{shown}={meant}"))
    raise SpecError(Mistake(where, what, f"write --set {section}.{shown}.KEY=..., where KEY is {_KEYS[section]}"))


def _section_of(data: dict[str, Any], name: str) -> str | None:
    """The section that declares a name which stands where a section should."""
    sections = {key: own for key, own in data.items() if key in _NAMED and isinstance(own, dict)}
    if name in data or name in _SECTIONS:
        return None
    return next((key for key, own in sections.items() if name in own), None)


def _in_phases(data: dict[str, Any], shown: str, where: str) -> Iterator[Path]:
    """What mesh.* means in phases that have meshes of their own: all meshes."""
    if not shown.startswith("mesh.*."):
        return
    phases = data.get("phases")
    for name, own in phases.items() if isinstance(phases, dict) else ():
        if isinstance(own, dict) and isinstance(own.get("mesh"), list):
            yield from (("phases", name, *path) for path in _paths(own, shown, where))


def _keys(node: Any, step: str, path: Path, where: str) -> list[str | int]:
    """The keys that one step of a path means below a node."""
    if step == "*":
        keys: list[str | int] = []
        if isinstance(node, dict | list):
            keys = list(node) if isinstance(node, dict) else list(range(len(node)))
        if not keys:
            raise SpecError(Mistake(where, f"{dotted(path) or 'the file'} has nothing for * to mean", "name the key"))
        return keys
    if isinstance(node, list):
        return [_index(node, step, path, where)]
    return [step]


def _check_declared(found: list[tuple[Path, Any]], step: str, where: str) -> None:
    """Refuse a new name in a section of names."""
    for path, node in found:
        names = node if isinstance(node, dict) else {}  # what else stands there is a mistake of the file
        if len(path) == 1 and path[0] in _NAMED and step not in names and step != "*":
            remedy = did_you_mean(step, names, "declare it in the file first")
            raise SpecError(Mistake(where, f"{path[0]} has no {step}", remedy))


def _index(items: list[Any], step: str, path: Path, where: str) -> int:
    try:
        index = int(step)
    except ValueError:
        what = f"{dotted(path)} is a list, so {step} is no key of it"
        raise SpecError(Mistake(where, what, f"write an index such as {dotted((*path, 0))}, or * for all")) from None
    if not -len(items) <= index < len(items):
        what = f"{dotted(path)} has {len(items)} entries, so there is no entry {index}"
        raise SpecError(Mistake(where, what, f"write an index from 0 to {len(items) - 1}"))
    return index % len(items)


def _below(node: Any, key: str | int) -> Any:
    if isinstance(node, list) and isinstance(key, int):
        return node[key]
    return node.get(key) if isinstance(node, dict) else None


def _assign(data: dict[str, Any], path: Path, new: Any, where: str) -> Path:
    """Set one value, and tell where: at the path, or at the value: of the long form that stands there.

    A plain value on the way, such as 0.3 for {value: 0.3}, becomes its long form.
    """
    node: Any = data
    for i, (step, following) in enumerate(pairwise(path)):
        inner = _below(node, step)
        if not isinstance(inner, dict | list):
            if not isinstance(following, str) or isinstance(inner, bool):
                raise SpecError(
                    Mistake(where, f"{dotted(path[: i + 1])} is {in_words(inner)}", "name what stands there")
                )
            short = "expression" if path[0] == "residuals" else "value"
            inner = {} if inner in (None, "linear", "slack") else {short: inner}
            node[step] = inner
        node = inner
    last, old = path[-1], _below(node, path[-1])
    if isinstance(old, dict) and "value" in old and not isinstance(new, dict | list):
        old["value"] = new
        return *path, "value"
    node[last] = new
    return path
