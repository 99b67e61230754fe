"""Arguments of the command line that are words, taken as they were typed.

typer 0.25 and later checks every argument by pydantic, which takes a tenth of a small solve to load; a word needs no
check. What is no word, a path or a number, is left to typer. Its way to ask is private to it: a typer that has
another one does as it would have done.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

ASKED = "get_runtime_param"


def as_typed(parameters: list[Any]) -> list[Any]:
    """The parameters of a command, which now take words without pydantic.

    parameters: of typer's command.
    """
    for own in parameters:
        if hasattr(own, ASKED) and hasattr(own, "type_descriptor") and ASKED not in vars(own):
            setattr(own, ASKED, _Words(own.type_descriptor.annotation, getattr(own, ASKED)).itself)
    return parameters


class _Words:
    """What typer asks for a value: annotation, of the parameter; checked, gives what typer would have asked."""

    def __init__(self, annotation: Any, checked: Callable[[], Any]) -> None:
        self.annotation, self.checked = annotation, checked

    def itself(self) -> _Words:
        return self

    def coerce(self, value: Any, param: Any, ctx: Any) -> Any:
        """The value that the command is called with."""
        if value is None:
            return () if param.multiple or param.nargs == -1 else None
        if self.annotation is str and isinstance(value, str):
            return value
        if self.annotation == list[str] and not isinstance(value, str) and all(isinstance(own, str) for own in value):
            return list(value)
        return self.checked().coerce(value, param=param, ctx=ctx)
