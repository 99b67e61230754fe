"""How a function of the file is declared: drag(v, h)."""

from __future__ import annotations

import re
from typing import Any, NamedTuple

_SIGNATURE = re.compile(r"\s*([^()\s]+)\s*\((.*)\)\s*")


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
