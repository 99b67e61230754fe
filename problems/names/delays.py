"""States at earlier times, x(t - tau): which there are, how long before, what is wrong with those that cannot be."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from math import isfinite
from typing import NamedTuple

from ..expressions.delays import Delay, delay_of
from ..expressions.expression import Expression, parse
from ..expressions.functions import FUNCTIONS
from ..expressions.tokens import ExpressionError
from ..expressions.tree import Node, OperatorChain
from ..text import did_you_mean
from ..yaml.document import Path
from ..yaml.locations import Finding
from .occurrences import TRAJECTORY, Use

_NOT_HERE = (
    "a state at an earlier time is for what holds at every time: rates, residuals, path constraints, integrals",
    "for a value at one end, declare a state or an expression that has it",
)


class DelayedState(NamedTuple):
    """A state at t - lag. name: as expressions have it. path: where it stands first. lag: in the unit of time."""

    name: str
    state: str
    lag: float
    path: Path


def parameters_of(uses: Iterable[Use]) -> set[str]:
    """The names that stand in the delays of expressions."""
    found = set()
    for use in uses:
        for leaf in use.expression.leaves:
            if (delay := delay_of(leaf.name)) and (lag := _lag(delay)):
                found |= {name.name for name in lag.leaves}
    return found


def delayed_states(
    uses: Iterable[Use],
    states: Iterable[str],
    value: Callable[[Node], float | None],
    findings: list[Finding],
) -> dict[str, DelayedState]:
    """The states that expressions take at earlier times, by their names there.

    uses: the expressions of a phase.
    states: the names of its states.
    value: of a tree of parameters; None for another.
    findings: what is wrong with a delay is added to them.
    """
    found: dict[str, DelayedState] = {}
    known = set(states)
    for use in uses:
        for leaf in use.expression.leaves:
            delay = delay_of(leaf.name)
            if delay is None or delay.state not in known or use.context != TRAJECTORY or delay.name in found:
                continue
            lag, trouble = _value(delay, value)
            if trouble:
                findings.append(Finding(use.path, *trouble))
            found[delay.name] = DelayedState(delay.name, delay.state, lag, use.path)
    return found


def no_delay(delay: Delay, roles: Mapping[str, str], state: str) -> tuple[str, str]:
    """What is wrong with a name that means no state at an earlier time, and the remedy.

    delay: the name.
    roles: of all names.
    state: the role of states.
    """
    role = roles.get(delay.state)
    if role == state:
        return f"{delay.name} stands where it has no value: {_NOT_HERE[0]}", _NOT_HERE[1]
    if role is None:
        known = [*(name for name, own in roles.items() if own == state), *FUNCTIONS]
        remedy = did_you_mean(delay.state, known, "only states have values at earlier times")
        return f"{delay.name}: there is no state {delay.state}", remedy
    remedy = (
        f"declare a state whose rate makes it {delay.state}, or write {delay.state}*(t - {delay.lag}) for a product"
    )
    return f"{delay.name}: {delay.state} is no state, and only states can be taken at an earlier time", remedy


def _lag(delay: Delay) -> Expression | None:
    try:
        return parse(delay.lag)
    except ExpressionError:
        return None


def _value(delay: Delay, value: Callable[[Node], float | None]) -> tuple[float, tuple[str, str] | None]:
    """How long a delay is, or 1 and what is wrong with it."""
    lag = _lag(delay)
    wanted = "write one, as x(t - 0.5), x(t - tau) or x(t - (a + b))"
    if lag is None or (isinstance(lag.root, OperatorChain) and _sums(lag.root) and not delay.lag.startswith("(")):
        return 1.0, (f"{delay.name}: what is taken from t is no single number or product", wanted)
    length = value(lag.root)
    if length is None:
        what = f"{delay.name}: {delay.lag} is not known before the solution is"
        return 1.0, (what, "make the delay of numbers and parameters")
    if not (isfinite(length) and length > 0):
        return 1.0, (f"{delay.name}: the delay is {length:g}", "write a positive one, x(t - tau) with tau > 0")
    return length, None


def _sums(chain: OperatorChain) -> bool:
    return any(link.symbol in "+-" for link in chain.links)
