"""Whether a file has vectors at all, and whether an override means one."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

from ..yaml.document import Path
from .component import KEPT
from .scope import DECLARED, DEFINED, RATES, entries_of
from .texts import OWN
from .write_out import SECTIONS

_SIGNS = re.compile(rf"\b(?:{'|'.join(sorted(OWN))})\s*\(|@|(?:^|[(,])\s*\[")


def has_vectors(data: Mapping[str, Any]) -> bool:
    """Whether plain data have vectors anywhere: a size, a list as a value, or a function of vectors."""
    owners = [data, *(own for own in entries_of(data, "phases").values() if isinstance(own, dict))]
    return any(_declares(own) or _calls(own, ()) for own in owners)


def _declares(data: Mapping[str, Any]) -> bool:
    declared = (own for section in DECLARED for own in entries_of(data, section).values() if isinstance(own, dict))
    defined = (own for section in DEFINED for own in entries_of(data, section).values())
    values = (own.get("value") if isinstance(own, dict) else own for own in defined)
    return any("size" in own or any(isinstance(own.get(key), list) for key in RATES) for own in declared) or any(
        isinstance(own, list) and (len(own) > 1 or isinstance(next(iter(own), None), list)) for own in values
    )


def _calls(node: Any, path: Path) -> bool:
    """Whether a text in the sections that are looked at has what only vectors have."""
    if isinstance(node, str):
        return _SIGNS.search(node) is not None
    if isinstance(node, list):
        return any(_calls(own, (0,)) for own in node)
    if isinstance(node, dict):
        return any(_calls(own, (key,)) for key, own in node.items() if (path or key in SECTIONS) and key not in KEPT)
    return False


def concerns(shown: str, data: Mapping[str, Any]) -> bool:
    """Whether an override means a value as the file has it, with its vectors, and not one that is made of them.

    shown: its path, parameters.J or states.q.initial; but states.q1.initial is of what is made.
    data: of the file.
    """
    steps = shown.replace("[", ".").replace("]", "").split(".")
    section = steps[0]
    if section not in SECTIONS:
        return False
    return len(steps) < 2 or section not in (*DECLARED, *DEFINED) or steps[1] in (*entries_of(data, section), "*")
