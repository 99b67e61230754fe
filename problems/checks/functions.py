"""How functions of the file are declared: drag(v, h)."""

from __future__ import annotations

from collections.abc import Iterator

from ..expressions.signature import name_trouble, signature
from ..text import brief
from ..yaml.document import Path
from ..yaml.locations import Finding

MAX_ARGUMENTS = 20


def signature_troubles(path: Path, key: str) -> Iterator[Finding]:
    """What is wrong with the key of a function, but for its name.

    path: where it stands.
    key: with a parenthesis in it.
    """
    own = signature(key)
    if own is None:
        remedy = 'write name(argument, argument); inside { } in quotes: {"drag(v, h)": v**2*exp(-h)}'
        yield Finding(path, f'"{brief(key)}" cannot be a name, nor a name with arguments', remedy)
        return
    if not 1 <= len(own.arguments) <= MAX_ARGUMENTS:
        remedy = f"write {own.name} alone" if not own.arguments else f"give it at most {MAX_ARGUMENTS}"
        yield Finding(path, f"{own.name} has {len(own.arguments) or 'no'} arguments", remedy)
    for i, argument in enumerate(own.arguments):
        if trouble := name_trouble(argument):
            yield Finding(path, f"argument {i + 1} of {brief(own.name)}: {trouble[0]}", trouble[1])
        elif argument in own.arguments[:i]:
            yield Finding(path, f"{own.name} has two arguments {argument}", "give each a name of its own")
