"""What pydantic found wrong with a file, in plain words: one finding for each mistake."""

from __future__ import annotations

import types
from collections.abc import Mapping
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from ..text import brief, did_you_mean
from ..wishes.keys import key_wish, meant
from ..wishes.lines import entry
from ..wishes.values import value_wish
from ..yaml.document import Path, in_words
from ..yaml.locations import MAX_FINDINGS, UNKNOWN_KEY, Finding, Locations
from .spec import Spec

# How the sections are written, by key; for other keys their description says it.
EXAMPLES = {
    "time": "{initial: 0, final: 2}",
    "model": "{kind: chain, links: [{mass: 1, length: 0.5, motor: true}]}",
    "cart": "{mass: 1, motor: u}",
    "links": "[{mass: 1, length: 0.5, motor: true}]",
    "initial": "0, or {lower: 0, upper: 1}",
    "final": "1, or {lower: 0.5, upper: 3}",
    "parameters": "{m: 2.0}",
    "expressions": "{power: u*v}",
    "integrals": "{work: F*v}",
    "tables": "{rho: {points: {h: [0, 1e4, 2e4]}, values: [1.2, 0.4, 0.09]}}",
    "points": "{h: [0, 1e4, 2e4]}",
    "units": "{h: m}",
    "states": "{x: {rate: v, initial: 0, final: 1}}",
    "velocity": "{name: v, initial: 0}",
    "controls": "{u: {lower: -5, upper: 5}}",
    "algebraic": "{F: {unit: N}}",
    "residuals": "[F - k*x]",
    "optimize": "{p: {lower: 0, upper: 1}}",
    "objective": "{minimize: {integral: u**2}}",
    "minimize": "{integral: u**2}",
    "maximize": '{terminal: "x[final]"}',
    "nonsmooth": "slack, or {tanh: 0.01}",
    "tanh": "0.01, or [1, 0.1]",
    "sqrt": "0.01, or [1, 0.1]",
    "constraints": "{path: [{expression: u*v, upper: 3}]}",
    "path": "[{expression: u*v, upper: 3}]",
    "boundary": '[{expression: "x[final] - x[initial]", equals: 1}]',
    "integral": "[{expression: u*v, upper: 10}]",
    "phases": "{boost: {time: {final: 10}}, coast: {controls: {u: {upper: 0}}}}",
    "waypoints": "[{x: 1, y: 2}, {x: 3}]",
    "complementarity": "[{a: gap, b: force}]",
    "relax": "[1, 0.01, 1e-6]",
    "continuation": "{parameters.g: [0, 5]}",
    "guess": "linear, or {constants: {u: 1}}",
    "constants": "{u: 1}",
    "keyframes": "{x: [0, 0.5, 1]}",
    "refine": "{tolerance: 1e-8}",
    "mesh": "[{method: trapezoid, segments: 20}]",
    "solver": "{max_iter: 500}",
    "drawing": "[{line: [[0, 0], [x, y]]}, {circle: [x, y], radius: 0.1, trail: true}]",
    "line": "[[0, 0], [x, y]]",
    "point": "[x, y]",
    "circle": "[x, y]",
    "box": "[x, y]",
    "reference": "{objective: 6.0, tolerance: 1e-4}",
}
OF_THE_FILE = {"units": "off", "links": "[{from: boost, to: coast, except: [m]}]"}
"""Of the keys that mean something else at the top level of a file."""


LENGTH_IN_PHASE = 3  # of the path of a key of a phase, phases.boost.mesh

_STRUCTURES = {"model_type": "a mapping", "dict_type": "a mapping", "list_type": "a list"}
"""What pydantic calls the wrong type of what has something below it -> what it should be."""


def findings(error: ValidationError, locations: Locations) -> list[Finding]:
    """One finding for each error, at the longest part of its path that stands in the file."""
    # one more than will be shown
    errors = error.errors(include_url=False)[: MAX_FINDINGS + 1]
    extra = [e["loc"] for e in errors if e["type"] == "extra_forbidden"]
    # a key that is only misspelt is not missing as well
    there = {(*path[:-1], key) for path in extra if (key := meant(path, _keys(path[:-1])))}
    return [_finding(e, locations) for e in errors if e["type"] != "missing" or e["loc"] not in there]


def _finding(error: ErrorDetails, locations: Locations) -> Finding:
    path: Path = error["loc"]
    what, remedy = _words(error, path)
    if error["type"] != "missing":
        while path and not locations.known(path):
            path = path[:-1]
    return Finding(path, what, remedy, UNKNOWN_KEY if error["type"] == "extra_forbidden" else "")


def _words(error: ErrorDetails, path: Path) -> tuple[str, str]:
    """What is wrong and how to mend it, in our words for every type of error that pydantic knows."""
    given, context = in_words(error.get("input")), error.get("ctx", {})
    key, written = brief(path[-1]) if path else "", how_written(path)
    if error["type"] not in ("missing", "extra_forbidden") and (wish := value_wish(path, error.get("input"))):
        kind = _STRUCTURES.get(error["type"])
        return (f"this must be {kind}, not {given}" if kind else wish[0]), wish[1]
    if error["type"] == "mistake":
        return context["what"], context["remedy"]
    if error["type"] == "missing" and path == ("trajopt",):
        return "the version of the file format is missing", "write trajopt: 1 at the top"
    if error["type"] == "extra_forbidden":
        if (wanted := key_wish(path, error.get("input"))) and wanted.key in ("", *_keys(path[:-1])):
            return f'unknown key "{key}"' + (f": {wanted.what}" if wanted.what else ""), f"write {wanted.line}"
        return f'unknown key "{key}"', _other_key(path)
    words = {
        "missing": (f"{key} is missing", f"add {written}"),
        **dict.fromkeys(
            _STRUCTURES, (f"this must be {_STRUCTURES.get(error['type'])}, not {given}", f"write {written}")
        ),
        "list_type": (f"this must be a list, not {given}", _as_list(path, error.get("input"), written)),
        "bool_type": (f"this must be true or false, not {given}", "write true or false"),
        "bool_parsing": (f"this must be true or false, not {given}", "write true or false"),
        "string_type": (f"this must be a text, not {given}", "put the text in quotes"),
        "literal_error": (f"{given} is not one of the choices", f"write {context.get('expected', '')}"),
        "too_short": (f"there must be at least {context.get('min_length')} here", f"write {written}"),
        "too_long": (f"there are more than {context.get('max_length')} here", "remove some"),
        "string_too_long": (f"this text is longer than {context.get('max_length')} characters", "shorten it"),
    }
    return words.get(error["type"], (f"this cannot be {given}", f"write {written}"))


def _as_list(path: Path, value: object, written: str) -> str:
    """A list of the value, or of the items of a mapping by their names, where that is short; else an example."""
    keys, items, first = _keys((*path, 0)), [value], "- "
    if isinstance(value, Mapping) and value and all(isinstance(item, Mapping) for item in value.values()):
        items = [{"name": name, **item} for name, item in value.items()] if "name" in keys else []
        first = f"- name: {brief(next(iter(value)))}" if items else "- "
    line = entry(brief(path[-1]) if path else "", items or None)
    return f"write {line}" if not line.endswith(":") else f'start each item with "{first}", or write {written}'


def _other_key(path: Path) -> str:
    keys = _keys(path[:-1])
    if path[0] == "phases" and len(path) == LENGTH_IN_PHASE and path[-1] in _keys(()):
        return f"put {path[-1]}: at the top level, beside phases: it is of the whole problem"
    return did_you_mean(path[-1], keys, "the keys here are " + ", ".join(keys))


def _keys(path: Path) -> list[str]:
    """The keys that the mapping at this path may have."""
    owner = _field(path)
    if not (isinstance(owner, type) and issubclass(owner, BaseModel)):
        return []
    return [field.alias or name for name, field in owner.model_fields.items()]


def how_written(path: Path) -> str:
    """How the value at this path is written, or the mapping or the list that it is an entry of: "for example ..."."""
    for n in range(len(path), 0, -1):
        owner = _field(path[: n - 1])
        key = str(path[n - 1])
        if isinstance(owner, type) and issubclass(owner, BaseModel) and key in owner.model_fields:
            plain = _field(path[:n]) is Any  # as the integral of minimize: and the objective of reference:
            example = OF_THE_FILE.get(key) if n == 1 else None
            if (example or key in EXAMPLES) and not plain:
                return f"for example {key}: {example or EXAMPLES[key]}"
            return f"{key}: {owner.model_fields[key].description}"
    return "what trajopt schema says"


def _field(path: Path) -> Any:
    """The annotation of the value at this path: a model where the value is a mapping with fixed keys."""
    annotation: Any = Spec
    for step in path:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            known = annotation.model_fields.get(str(step))
            annotation = _bare(known.annotation) if known else None
        else:
            arguments = get_args(annotation)
            annotation = _bare(arguments[-1]) if arguments else None
    return annotation


def _bare(annotation: Any) -> Any:
    """A type without the None beside it and without the validators that pydantic finds in its annotation."""
    if get_origin(annotation) in (types.UnionType, Union):
        annotation = next(a for a in get_args(annotation) if a is not type(None))
    return annotation.__origin__ if get_origin(annotation) is Annotated else annotation
