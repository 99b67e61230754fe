"""What pydantic found wrong with a file, in plain words: one finding for each mistake."""

from __future__ import annotations

import types
from typing import Any, get_args, get_origin

from pydantic import BaseModel, ValidationError

from .places import MAX_FINDINGS, Finding, Places
from .spec import Spec
from .syntax import nearest
from .yamltext import Path, brief, kind


def findings(error: ValidationError, places: Places) -> list[Finding]:
    """One finding for each error, at the longest part of its path that stands in the file."""
    # one more than will be shown
    errors = error.errors(include_url=False)[: MAX_FINDINGS + 1]
    extra = [e["loc"] for e in errors if e["type"] == "extra_forbidden"]
    # a key that is only misspelt is not missing as well
    meant = {(*path[:-1], close) for path in extra if (close := nearest(path[-1], _keys(path[:-1])))}
    return [_finding(e, places) for e in errors if e["type"] != "missing" or e["loc"] not in meant]


def _finding(error: dict[str, Any], places: Places) -> Finding:
    path: Path = error["loc"]
    what, remedy = _words(error, path)
    if error["type"] != "missing":
        while path and not places.known(path):
            path = path[:-1]
    return Finding(path, what, remedy)


def _words(error: dict[str, Any], path: Path) -> tuple[str, str]:
    """What is wrong and how to mend it. Types of pydantic's that no field can give fall through to its own words."""
    given, context = kind(error.get("input")), error.get("ctx", {})
    key, form = brief(path[-1]) if path else "", _describe(path)
    if error["type"] == "mistake":
        return context["what"], context["remedy"]
    if error["type"] == "extra_forbidden":
        return f'unknown key "{key}"', _other_key(path)
    words = {
        "missing": (f"{key} is missing", f"add {key}: {form}"),
        "model_type": (f"this must be a mapping, not {given}", f"write key: value below it: {form}"),
        "dict_type": (f"this must be a mapping, not {given}", f"write key: value below it: {form}"),
        "list_type": (f"this must be a list, not {given}", f'start each item with "- ": {form}'),
        "string_type": (f"this must be a text, not {given}", "put the text in quotes"),
        "literal_error": (f"{given} is not one of the choices", f"write {context.get('expected', '')}"),
        "too_short": (f"there must be at least {context.get('min_length')} here", f"add what is missing: {form}"),
        "too_long": (f"there are more than {context.get('max_length')} here", "remove some"),
        "string_too_long": (f"this text is longer than {context.get('max_length')} characters", "shorten it"),
    }
    return words.get(error["type"], (error["msg"], f"write {form}"))


def _other_key(path: Path) -> str:
    keys = _keys(path[:-1])
    close = nearest(path[-1], keys)
    return f"did you mean {close}?" if close else "the keys here are " + ", ".join(keys)


def _keys(path: Path) -> list[str]:
    """The keys that the mapping at this path may have."""
    owner = _field(path)
    return list(owner.model_fields) if isinstance(owner, type) and issubclass(owner, BaseModel) else []


def _describe(path: Path) -> str:
    """The description of the field at this path, or of the mapping that the path is an entry of."""
    for n in range(len(path), 0, -1):
        owner = _field(path[: n - 1])
        if isinstance(owner, type) and issubclass(owner, BaseModel) and path[n - 1] in owner.model_fields:
            return owner.model_fields[path[n - 1]].description
    return "see trajopt schema"


def _field(path: Path) -> Any:
    """The annotation of the value at this path: a model where the value is a mapping with fixed keys."""
    annotation: Any = Spec
    for step in path:
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            known = annotation.model_fields.get(step)
            annotation = _without_none(known.annotation) if known else None
        else:
            arguments = get_args(annotation)
            annotation = _without_none(arguments[-1]) if arguments else None
    return annotation


def _without_none(annotation: Any) -> Any:
    if get_origin(annotation) is types.UnionType:
        return next(a for a in get_args(annotation) if a is not type(None))
    return annotation
