"""What people look for in expressions and the language lacks, and what to write in its place."""

from __future__ import annotations

import re
from typing import NamedTuple

from ..text import did_you_mean
from .functions import FUNCTIONS


class Lack(NamedTuple):
    """what: that it is missing, and why. remedy: what does its work."""

    what: str
    remedy: str


ALIASES = {
    "ln": "log({})",
    "log2": "log({})/log(2)",
    "exp2": "2**({})",
    "arcsin": "asin({})",
    "arccos": "acos({})",
    "arctan": "atan({})",
    "tg": "tan({})",
    "sqr": "({})**2",
    "square": "({})**2",
    "pow": "a**b",
    "fabs": "abs({})",
    "arctan2": "atan2({})",
    "erfc": "1 - erf({})",
    "sgn": "sign({}, eps), where eps is the width of the smooth change",
    "signum": "sign({}, eps), where eps is the width of the smooth change",
    **{f"{name}d": name + "(pi/180*({}))" for name in ("sin", "cos", "tan")},
    **{f"{name}d": "180/pi*" + name + "({})" for name in ("asin", "acos", "atan", "atan2")},
    **dict.fromkeys(("deg2rad", "radians", "rad"), "pi/180*({})"),
    **dict.fromkeys(("rad2deg", "degrees"), "180/pi*({})"),
    "final": "{}[final]",
    "initial": "{}[initial]",
}
"""Names of functions that exist elsewhere -> what to write for them, with {} for the argument."""

_AT_ANOTHER_TIME = re.compile(r"t\s*[-+].*|.*[-+*/]\s*t")  # t - 0.5, 0.5 + t, 2*t

_SMOOTH_SWITCH = "write step(x - a, eps), which goes from 0 to 1 where x passes a, and eps is the width of the change"
_SMOOTH_BRANCH = "write a + (b - a)*step(x - c, eps), which goes from a to b where x passes c, over the width eps"
_EARLIER_STATE = (
    "write x(t - tau) for the state x a constant time tau ago, and history: in x for its values before the start"
)


def _jump(name: str) -> Lack:
    return Lack(f"there is no {name}: it jumps, and a solver that trusts its gradient stalls there", _SMOOTH_SWITCH)


def _branch(name: str) -> Lack:
    return Lack(f"there is no {name}: expressions have no branches, for what they say must be smooth", _SMOOTH_BRANCH)


def _rate(name: str) -> Lack:
    remedy = "write the expression of its rate, or declare the state without a rate and write x[rate] in a residual"
    return Lack(f"there is no {name}: expressions are not differentiated by time", remedy)


def _integral(name: str) -> Lack:
    remedy = (
        "name the integrand under integrals:, as {work: F*v}, and write integral.work, or integral: in the objective"
    )
    return Lack(f"there is no {name}: expressions hold values at one time", remedy)


def _random(name: str) -> Lack:
    what = f"there is no {name}: a problem has no random numbers, so that it means the same at every solve"
    remedy = (
        "write a disturbance as a function of t, such as 0.1*sin(7*t), or set parameters drawn elsewhere with --set"
    )
    return Lack(what, remedy)


def _delay(name: str) -> Lack:
    return Lack(f"there is no {name}: what is delayed is a state", _EARLIER_STATE)


def _data(name: str) -> Lack:
    remedy = (
        "declare it under tables:, as rho: {points: {h: [0, 1e4, 2e4]}, values: [1.2, 0.4, 0.09]}, and write rho(h)"
    )
    return Lack(f"there is no {name}: data stand in a table, which is called by its name", remedy)


def _remainder(name: str) -> Lack:
    remedy = f"an angle needs none, sin and cos repeat by themselves; for a jump {_SMOOTH_SWITCH}"
    return Lack(_jump(name).what, remedy)


_KINDS = {
    _jump: "floor ceil round trunc int heaviside",
    _remainder: "mod fmod remainder",
    _branch: "if ifelse if_else piecewise where select switch",
    _rate: "diff der deriv derivative ddt",
    _integral: "integral integrate",
    _random: "random rand randn randint noise",
    _delay: "delay delayed",
    _data: "interp interp1 interp1d interp2 interpolate interpolant lookup spline pchip table griddedInterpolant",
}

LACKING = {name: kind(name) for kind, names in _KINDS.items() for name in names.split()} | {
    "sum": Lack(
        "a sum is over a loop or over a vector", "write sum(i in 1..3, x{i}**2), or sum(q) for a vector q, or use +"
    )
}


_FINAL = ("tf", "t_f", "tF", "T", "end", "final", "t_final", "tend", "t_end", "-1")
_INITIAL = ("t0", "t_0", "start", "initial", "t_initial", "0")


def end_meant(argument: str) -> str | None:
    """How a value at an end is written, with {0} for the name, for x(tf), x[end] and x(0); None for other arguments."""
    if argument == "1":
        return "{0}[final] for the value at the final time, {0}[initial] for the one at the initial time"
    if re.fullmatch(r"\d+(\.\d*)?", argument) and float(argument) > 0:
        return "{0}[final] if that is the final time; for a time between the ends give waypoints: or phases:"
    return "{0}[final]" if argument in _FINAL else "{0}[initial]" if argument in _INITIAL else None


def at_another_time(name: str, argument: str) -> Lack | None:
    """What is said of x(t - 0.5) and of x(t), for an x that is no function; None if t is not the argument.

    argument: the text between the parentheses.
    """
    argument = argument.strip()
    if name in FUNCTIONS:
        return None
    if name != "t" and (end := end_meant(argument)):
        what = f"{name} is not a function, and has a value at the ends of time only where it says which"
        return Lack(what, f"write {end.format(name)}")
    meant = did_you_mean(name, FUNCTIONS)
    if argument == "t":
        what = f"there is no function {name}" if meant else f"{name} is not a function"
        plain = f"a state or control is written without (t): {name}"
        return Lack(what, f"{meant} If not, {plain}" if meant else plain)
    if not _AT_ANOTHER_TIME.fullmatch(argument):
        return None
    what = f"{name} is not a function, and a state can be taken at t and at an earlier time t - tau only"
    return Lack(what, f"{meant + ' If not, ' if meant else ''}{_EARLIER_STATE}; write {name}*(...) for a product")
