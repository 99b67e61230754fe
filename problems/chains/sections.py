"""Sections of the data of a file, for what is written out into them; what is mistaken is left to the schema."""

from __future__ import annotations

from typing import Any


def mapping_in(data: dict[str, Any], key: str) -> dict[str, Any]:
    """A section of names, made if it is not there or empty.

    data: of the file.
    key: of the section.
    """
    found: dict[str, Any] = _in(data, key, dict)
    return found


def list_in(data: dict[str, Any], key: str) -> list[Any]:
    """A list, made if it is not there or empty.

    data: that has it, of the file or a section.
    key: of the list.
    """
    found: list[Any] = _in(data, key, list)
    return found


def _in(data: dict[str, Any], key: str, kind: type) -> Any:
    if data.get(key) is None:
        data[key] = kind()
    return data[key] if isinstance(data[key], kind) else kind()
