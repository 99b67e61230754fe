"""Units as texts -> measures that can be multiplied and compared. Pint knows the units; this is the only user of it.

A file's unit is a text for tables and plots first, so whatever pint cannot read is no mistake: it is unknown.
"""

from __future__ import annotations

import re
from contextlib import suppress
from functools import cache
from typing import Any

from ..lean.hidden import hidden
from ..lean.records import dataclass

ROUNDING = 1e-6
"""Of the ratio of two scales: units whose scales differ by less are the same, since conversions are rounded."""

MAX_LENGTH = 60
"""Of the text of a unit; pint computes the powers in it, so they are kept small as well."""

PLAIN = ("-", "–", "[-]", "1")
"""How people write that something is a pure number."""

NO_UNITS = frozenset(("unit", "units", "pcs", "point", "points", "particle", "particles", "mass"))
"""Words for what is counted or meant, which pint takes for a micro-nit, a parsec, a length of print, 1/N_A of a mole
and a milli-arcsecond."""

NUMBER = "a pure number"

_LARGE_POWER = re.compile(r"(\*\*|\^)[^A-Za-zµμΩ°]*(\*\*|\^)|(\*\*|\^)\s*\(?\s*[-+]?\d{3,}|\d{7,}|[eE][-+]?\d{3,}")


@dataclass(frozen=True)
class Measure:
    """A unit with its scale, as a quantity of pint.

    text: as the file writes it; "" if it follows from other units. numeric: whether plain numbers are factors of what
    has it, as in 2*x. clock: whether it is of the time itself.
    """

    quantity: Any
    text: str = ""
    numeric: bool = False
    clock: bool = False

    def times(self, other: Measure) -> Measure:
        return Measure(self.quantity * other.quantity, "", self.numeric or other.numeric)

    def over(self, other: Measure) -> Measure:
        return Measure(self.quantity / other.quantity, "", self.numeric or other.numeric)

    def power(self, exponent: float) -> Measure:
        return Measure(self.quantity**exponent, "", self.numeric)

    @property
    def scale(self) -> float:
        """The number of units of the base (SI, rad) that it is."""
        try:
            return float(self.quantity.to_root_units().magnitude)
        except OverflowError:  # of a large power of a unit
            return float("inf")

    @property
    def pure(self) -> bool:
        """Whether it is of a pure number or an angle, whatever the scale."""
        return not any(round(power, 9) for power in self.quantity.dimensionality.values())

    @property
    def bare(self) -> bool:
        """Whether it is of a pure number in units of one, as sin(x) and a ratio; not of an angle."""
        return bool(self.quantity.unitless) and abs(self.scale - 1) < ROUNDING

    def __str__(self) -> str:
        if self.text and self.text not in PLAIN:
            return self.text
        shown = [_shown(self.quantity)]
        with suppress(OverflowError):  # of a large power of a unit
            shown.append(_shown(self.quantity.to_base_units()))
        return min(shown, key=len)

    @property
    def told(self) -> str:
        """What is said of what has it: "in m/s"."""
        return "a pure number" if str(self) == NUMBER else f"in {self}"


def _shown(quantity: Any) -> str:
    number, unit = float(quantity.magnitude), f"{quantity.units:~C}".replace("**", "^")
    return (f"{number:g} {unit}".strip() if abs(number - 1) > ROUNDING else unit) or NUMBER


@cache
def _registry() -> Any:
    with hidden("scipy", "dask", absent=True):  # it looks for them; with Pyomo, SciPy's statistics then take a second
        from pint import UnitRegistry

    registry: Any = UnitRegistry(on_redefinition="ignore")
    registry.define("newton_metre = newton * meter = Nm")  # pint's Nm is one of yarn
    return registry


@cache
def measure_of(text: str) -> Measure | None:
    """The measure of a unit; None where pint knows no such unit.

    text: as in a file: "m/s^2", "kg m^2", "1000 lbf", "deg", "1" for a pure number.
    """
    if text in PLAIN:
        return Measure(_registry().Quantity(1.0), text)
    if len(text) > MAX_LENGTH or _LARGE_POWER.search(text) or NO_UNITS & {*re.findall(r"[A-Za-z]+", text)}:
        return None
    try:
        quantity = _quantity(text)
        scale = float(quantity.to_root_units().magnitude)
    except Exception:  # pint raises what it meets: of units, of syntax, of arithmetic, assertions
        return None
    return Measure(quantity, text) if 0 < scale < float("inf") else None


def _quantity(text: str) -> Any:
    registry = _registry()
    try:
        unit = registry.parse_units(text)
    except ValueError:  # there is a number in it
        return registry.Quantity(registry.parse_expression(text)) * 1.0
    quantity = registry.Quantity(1.0, unit)
    if not quantity._is_multiplicative:  # degC, degF: differences can be multiplied, and are what rates are made of
        quantity = registry.Quantity(1.0, f"delta_{unit}")
    return quantity


def factor(given: Measure, wanted: Measure) -> str:
    """The number and the unit of what makes of one measure another of the same kind."""
    ratio = f"{given.scale / wanted.scale:.6g}"
    return f"value: {ratio}, unit: {_shown(wanted.quantity / given.quantity)}"


def pure() -> Measure:
    """Of a pure number that follows from functions, such as sin."""
    return Measure(_registry().Quantity(1.0))


def angle() -> Measure:
    """Radians, of what asin and others return."""
    return Measure(_registry().Quantity(1.0, "radian"))


def alike(a: Measure, b: Measure) -> bool:
    """Whether two measures are of one kind, whatever their scales: m and km, rad and deg and pure numbers."""
    return a.over(b).pure


def same(a: Measure, b: Measure) -> bool:
    """Whether two measures are the same, as N*m and kg*m^2/s^2."""
    return alike(a, b) and abs(a.scale / b.scale - 1) < ROUNDING
