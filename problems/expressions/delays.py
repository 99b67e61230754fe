"""A state at an earlier time, x(t - tau): in a tree it is a name of its own, "x(t - tau)"."""

from __future__ import annotations

import re
from typing import NamedTuple

_EARLIER = re.compile(r"t\s*-\s*(?=\S)(.*)")
_NAME = re.compile(r"([A-Za-z]\w*)\(t - (.+)\)", re.ASCII)


class Delay(NamedTuple):
    """The state, and the text of how long before t it is taken."""

    state: str
    lag: str

    @property
    def name(self) -> str:
        return f"{self.state}(t - {self.lag})"


def is_earlier(argument: str) -> bool:
    """Whether the text between the parentheses is a time before t: t - ..."""
    return _EARLIER.fullmatch(argument.strip()) is not None


def delayed(state: str, argument: str) -> Delay:
    """The delay that a call of a state means.

    state: its name.
    argument: a text for which `is_earlier` holds.
    """
    found = _EARLIER.fullmatch(argument.strip())
    assert found is not None
    return Delay(state, found[1].strip())


def delay_of(name: str) -> Delay | None:
    """What a name such as "x(t - tau)" means; None for another name."""
    found = _NAME.fullmatch(name)
    return Delay(*found.groups()) if found else None
