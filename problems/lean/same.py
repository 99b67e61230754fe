"""Records as keys of what is kept of them, for as long as they are the same objects."""

from __future__ import annotations

from typing import Generic, TypeVar

T = TypeVar("T")


class Same(Generic[T]):
    """A record as a key: it is the same as itself only, and hashed without a walk through what is in it."""

    __slots__ = ("own",)

    def __init__(self, own: T) -> None:
        self.own = own

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Same) and self.own is other.own

    def __hash__(self) -> int:
        return id(self.own)
