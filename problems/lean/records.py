"""`dataclass` as the standard library has it, made in a fifth of the time: there are 130, made at each start.

The standard library writes and compiles six methods a class. Here only `__init__` is; the others are the same for all
classes and look at the fields when they are called. With `slots` it is the library's own. A frozen class of ours has no
frozen subclass of the library's.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache, partial
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any

__all__ = ["dataclass"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, *, repr=True, eq=True, frozen=False, slots=False):
        """The class with the methods that `dataclasses.dataclass` gives it.

        cls: the class; None in `@dataclass(...)`.
        repr: told by its fields; else as any object.
        eq: compared and, if frozen, hashed by its fields; else by identity.
        frozen: a field that is set stays: FrozenInstanceError.
        slots: as of the standard library.
        """
        if cls is None:
            return partial(dataclass, repr=repr, eq=eq, frozen=frozen, slots=slots)
        if slots:
            return dataclasses.dataclass(cls, repr=repr, eq=eq, frozen=frozen, slots=True)
        shared = {"__repr__": _repr} if repr else {}
        if eq:
            shared["__eq__"] = _eq
        if frozen:
            shared |= {"__setattr__": _set_once, "__delattr__": _keep}
        own = set(cls.__dict__)
        for name, method in shared.items():
            if name not in own:
                setattr(cls, name, method)
        if eq and not cls.__dict__.get("__hash__"):  # None: Python says so of a class with an own `__eq__`
            cls.__hash__ = _hash if frozen else None
        return dataclasses.dataclass(cls, eq=False, repr=False)


@cache
def _values(kind: Any) -> Callable[[Any], Any]:
    """What gives the fields of an object that it is compared and hashed by."""
    names = [field.name for field in dataclasses.fields(kind) if field.compare]
    if len(names) > 1:
        return attrgetter(*names)
    return lambda record: tuple(getattr(record, name) for name in names)


@recursive_repr()
def _repr(self: Any) -> str:
    shown = [field.name for field in dataclasses.fields(self) if field.repr]
    return f"{type(self).__qualname__}({', '.join(f'{name}={getattr(self, name)!r}' for name in shown)})"


def _eq(self: Any, other: Any) -> Any:
    if other.__class__ is not self.__class__:
        return NotImplemented
    values = _values(self.__class__)
    return values(self) == values(other)


def _hash(self: Any) -> int:
    return hash(_values(self.__class__)(self))


def _set_once(self: Any, name: str, value: object) -> None:
    """`__init__` sets each field, and nobody sets it again."""
    own = self.__dict__
    if name in own or name not in self.__dataclass_fields__:
        raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")
    own[name] = value


def _keep(self: Any, name: str) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")


def only_fields(record: Any) -> dict[str, Any]:
    """The `__getstate__` of a record that is pickled without what it has worked out (`cached_property`).

    record: of one of these classes.
    """
    own = vars(record)
    return {name: own[name] for name in record.__dataclass_fields__ if name in own}
