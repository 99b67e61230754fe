"""Libraries that are loaded when a test asks for them: every worker reads all files, and few of these need each."""

from importlib import import_module
from typing import Any


class Lazily:
    def __init__(self, name: str) -> None:
        self.name = name

    def __getattr__(self, name: str) -> Any:
        """pytest asks every name of a file for private attributes, which must not load the library."""
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(import_module(self.name), name)


def lazily(name: str) -> Any:
    """The module of that name, loaded when something of it is asked for."""
    return Lazily(name)
