"""Mistakes with the ends of time where expressions are about every time."""

from .case import edits
from .good import GOOD

SCALED = (
    GOOD.replace("  power: u*v\n", '  power: u*v\n  share: "(t - t[initial])/t[duration]"\n')
    .replace("(u - c*v)/m", "'(u - c*v*(1 + share) - 0*t[final])/m'")
    .replace("final: T}\nstates", "final: {lower: 1, upper: T}}\nstates")
)
edit = edits(SCALED)


def rate(name: str, given: str, says: str):
    return edit(name, "0*t[final]", given, "states.v.rate", says)


ENDS_OVER_TIME = [
    rate(
        "a state at an end over time", "0*x[final]", "x[final] is a value at one end, but this expression is taken at"
    ),
    rate("another word for an end", "0*t[end]", "write t[initial] or t[final]"),
    rate("the end of a time that is a number", "0*t[2]", "write t[initial] or t[final]"),
    rate("the duration of a state", "0*x[duration]", "only the time has a duration: t[duration]"),
    rate("the duration by its name alone", "0*duration", 'unknown name "duration"; write t[duration]'),
    rate("the final time by another name", "0*tf", 'unknown name "tf"; write t[final]'),
    rate("the rate of time", "0*t[rate]", 'unknown name "t[rate]"'),
    rate("two marks", "0*t[final][initial]", "[ ] stands after a name only"),
    rate("a named share at an end over time", "0*share[final]", "share[final] is a value at one end, but this"),
    edit(
        "a bound that depends on the final time", "upper: u_max", "upper: 't[final]'", "controls.u.upper", "t is a time"
    ),
    edit("a value at the start of the duration", "final: d}", "final: 't[duration]'}", "states.x.final", "t is a time"),
    edit(
        "a final time of itself", "upper: T}}", "upper: 't[final]'}}", "time.final.upper", "t is a time, but this value"
    ),
    edit(
        "a share without an end", "+ c**2", "+ share", "objective.minimize.terminal", "share varies in time, but this"
    ),
]
