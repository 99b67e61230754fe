"""Angles, and sums of terms, as texts of the expression language."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

_COS = ("cos", "-sin", "-cos", "sin")
_SIN = ("sin", "cos", "-sin", "-cos")
"""Of an angle and 0, 1, 2, 3 right angles more."""

_EXACT = ("1", "0", "-1", "0")
"""cos of 0, 1, 2, 3 right angles."""


class Angle(NamedTuple):
    """sum_i parts[i] i + turns pi/2, rad, counter-clockwise; parts: name -> how often."""

    parts: Mapping[str, int]
    turns: int = 0

    def minus(self, other: Angle) -> Angle:
        parts = {name: self.parts.get(name, 0) - other.parts.get(name, 0) for name in {**self.parts, **other.parts}}
        return Angle({name: count for name, count in parts.items() if count}, (self.turns - other.turns) % 4)

    @property
    def text(self) -> str:
        return summed(scaled_angle(str(count), name) for name, count in self.parts.items())

    @property
    def cos(self) -> str:
        return f"{_COS[self.turns % 4]}({self.text})" if self.parts else _EXACT[self.turns % 4]

    @property
    def sin(self) -> str:
        return f"{_SIN[self.turns % 4]}({self.text})" if self.parts else _EXACT[(self.turns - 1) % 4]


def scaled_angle(*factors: str) -> str:
    """A product: factors of 1 left out, the sign in front; "" if a factor is zero, which "" counts as too."""
    plain = [factor.removeprefix("-") for factor in factors]
    if {"", "0"} & {*plain}:
        return ""
    kept = "*".join(factor for factor in plain if factor != "1") or "1"
    return f"-{kept}" if sum(factor.startswith("-") for factor in factors) % 2 else kept


def negated(term: str) -> str:
    return term.removeprefix("-") if term.startswith("-") or not term else f"-{term}"


def summed(terms: Iterable[str]) -> str:
    """A sum of terms, each with its sign in front; empty ones count as zero."""
    text = ""
    for term in filter(None, terms):
        sign = " - " if term.startswith("-") else " + "
        text += f"{sign}{term.removeprefix('-')}" if text else term
    return text or "0"


def grouped(terms: Iterable[str]) -> str:
    """A sum as a factor: in parentheses if it has several terms."""
    text = summed(terms)
    return f"({text})" if " " in text or text.startswith("-") else text
