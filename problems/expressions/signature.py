"""What may be a name, and how a function of the file is declared: drag(v, h)."""

from __future__ import annotations

import re
from collections.abc import Container
from typing import Any, NamedTuple

from ..text import brief
from .slips import MAX_NAME, RESERVED

_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")
_SIGNATURE = re.compile(r"\s*([^()\s]+)\s*\((.*)\)\s*")


def name_trouble(name: str, reserved: Container[str] = RESERVED) -> tuple[str, str] | None:
    """Why a name cannot be declared, whatever it is of, and the remedy; None if it can.

    name: to be declared.
    reserved: names with a meaning of their own.
    """
    if not _NAME.fullmatch(name) or len(name) > MAX_NAME:
        return f'"{brief(name)}" cannot be a name', f"use a letter, then letters, digits and _, at most {MAX_NAME}"
    if name in reserved:
        return f'the name "{name}" has a meaning of its own in expressions', f"choose another name, such as {name}1"
    return None


class Signature(NamedTuple):
    """The name of a function, and those of its arguments."""

    name: str
    arguments: tuple[str, ...]

    @property
    def called(self) -> str:
        """How it is written: drag(v, h)."""
        return f"{self.name}({', '.join(self.arguments)})"


def signature(key: str) -> Signature | None:
    """The function that a key of `expressions:` declares; None if it has no arguments."""
    found = _SIGNATURE.fullmatch(key)
    if found is None:
        return None
    name, inside = found.groups()
    return Signature(name, tuple(part.strip() for part in inside.split(",")) if inside.strip() else ())


def function_names(data: Any) -> frozenset[str]:
    """The names of the functions in the data of a problem file, in its phases too; mistaken ones as well."""
    found = set()
    phases = data.get("phases") if isinstance(data, dict) else None
    for own in (data, *(phases.values() if isinstance(phases, dict) else ())):
        written = own.get("expressions") if isinstance(own, dict) else None
        keys = (key for key in written if isinstance(key, str)) if isinstance(written, dict) else ()
        found |= {declared.name for key in keys if (declared := signature(key))}
    return frozenset(found)
