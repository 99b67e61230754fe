"""`dataclass` as the standard library has it, made in a twentieth of the time: there are 130, made at each start.

The standard library writes and compiles six methods a class. Here all classes share theirs, which look at the fields
when they are called. A frozen class of ours has no frozen subclass of the library's, and none has slots.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable
from functools import cache, partial
from operator import attrgetter
from reprlib import recursive_repr
from typing import TYPE_CHECKING, Any, NamedTuple

__all__ = ["dataclass"]

if TYPE_CHECKING:
    from dataclasses import dataclass
else:

    def dataclass(cls=None, /, *, repr=True, eq=True, frozen=False):
        """The class with the methods that `dataclasses.dataclass` gives it.

        cls: the class; None in `@dataclass(...)`.
        repr: told by its fields; else as any object.
        eq: compared and, if frozen, hashed by its fields; else by identity.
        frozen: a field that is set stays: FrozenInstanceError.
        """
        if cls is None:
            return partial(dataclass, repr=repr, eq=eq, frozen=frozen)
        shared: dict[str, Any] = {"__init__": _init} | ({"__repr__": _repr} if repr else {})
        if eq:
            shared["__eq__"] = _eq
        if frozen:
            shared |= {"__setattr__": _keep_as_it_is, "__delattr__": _keep}
        own = set(cls.__dict__)
        for name, method in shared.items():
            if name not in own:
                setattr(cls, name, method)
        if eq and not cls.__dict__.get("__hash__"):  # None: Python says so of a class with an own `__eq__`
            cls.__hash__ = _hash if frozen else None
        return dataclasses.dataclass(cls, init=False, eq=False, repr=False)


@cache
def _values(kind: Any) -> Callable[[Any], Any]:
    """What gives the fields of an object that it is compared and hashed by."""
    names = [field.name for field in dataclasses.fields(kind) if field.compare]
    if len(names) > 1:
        return attrgetter(*names)
    return lambda record: tuple(getattr(record, name) for name in names)


class _Form(NamedTuple):
    """The fields of a class by name, in their order.

    names: all of them. places: those that are given by place. known: values of those that need not be given, and
    makers: what makes such. after: its `__post_init__`, if it has one.
    """

    names: tuple[str, ...]
    places: tuple[str, ...]
    known: dict[str, Any]
    makers: dict[str, Callable[[], Any]]
    after: Callable[[Any], None] | None


@cache
def _form(kind: Any) -> _Form:
    fields = dataclasses.fields(kind)
    return _Form(
        tuple(own.name for own in fields),
        tuple(own.name for own in fields if not own.kw_only),
        {own.name: own.default for own in fields if own.default is not dataclasses.MISSING},
        {own.name: own.default_factory for own in fields if own.default_factory is not dataclasses.MISSING},
        getattr(kind, "__post_init__", None),
    )


def _init(self: Any, /, *values: Any, **named: Any) -> None:
    names, places, known, makers, after = _form(self.__class__)
    own = self.__dict__
    if not named and len(values) == len(names) == len(places):
        own.update(zip(names, values, strict=True))
    else:
        own.update(known)
        own.update(zip(places, values, strict=False))
        own.update(named)
        for name, make in makers.items():
            if name not in own:
                own[name] = make()
        wrong = named and not (named.keys() <= set(names) and named.keys().isdisjoint(places[: len(values)]))
        if len(own) != len(names) or len(values) > len(places) or wrong:
            told = f"{len(values)} by place, and {', '.join(named) or 'none'} by name"
            raise TypeError(f"{type(self).__qualname__} has the fields {', '.join(names)}; given were {told}")
    if after:
        after(self)


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


def _keep_as_it_is(self: Any, name: str, value: object) -> None:
    """`__init__` sets all fields past this."""
    raise dataclasses.FrozenInstanceError(f"cannot assign to field {name!r}")


def _keep(self: Any, name: str) -> None:
    raise dataclasses.FrozenInstanceError(f"cannot delete field {name!r}")


def only_fields(record: Any) -> dict[str, Any]:
    """The `__getstate__` of a record that is pickled without what it has worked out (`cached_property`).

    record: of one of these classes.
    """
    own = vars(record)
    return {name: own[name] for name in record.__dataclass_fields__ if name in own}
