"""Mistakes in named integrals, and in what is made of their values."""

from .case import edits
from .good import GOOD

WITH_INTEGRALS = (
    GOOD.replace("objective: {m", "integrals:\n  work: {value: u*v, unit: J}\n  spent: u**2\nobjective: {m")
    .replace("+ c**2", "+ integral.work/integral.spent")
    .replace('"x[final] - x[initial]", equals: d', '"x[final] - x[initial] + 0*integral.work", equals: d')
)
edit = edits(WITH_INTEGRALS)


def terminal(name: str, given: str, says: str):
    return edit(name, "integral.work/integral.spent", given, "objective.minimize.terminal", says)


INTEGRALS = [
    terminal("an unknown integral", "integral.wrok", 'there is no integral "wrok"; did you mean work?'),
    terminal("an integral at an end", "integral.work[final]", "integral.work is one number; write integral.work"),
    terminal("an integral by its name alone", "work", "work has a value at every time, but this expression is about"),
    terminal("an integral that is called", "integral(u*v)", "name the integrand under integrals:"),
    edit(
        "a total over time", "rate: v,", "rate: v*integral.work,", "states.x.rate", "write work for the integral so far"
    ),
    edit("a total in a bound", "upper: 3}", "upper: integral.work}", "constraints.path.0.upper", "before the solution"),
    edit(
        "a total in a named one", "power: u*v", "power: integral.work", "expressions.power", "known at the final time"
    ),
    edit("an integrand with an unknown name", "spent: u**2", "spent: uu**2", "integrals.spent", 'unknown name "uu"'),
    edit("an integrand at an end", "spent: u**2", "spent: x[final]", "integrals.spent", "this expression is taken at"),
    edit(
        "an integral like a state",
        "spent: u**2",
        "spent: u**2\n  x: u",
        "integrals.x",
        "x is already declared",
        line=21,
    ),
    edit(
        "an integral like a parameter", "spent: u**2", "spent: u**2\n  d: u", "integrals.d", "already declared", line=21
    ),
    edit("an integral of a word", "spent: u**2", "spent: u**2\n  sin: u", "integrals.sin", "has a meaning of", line=21),
    edit("an integral with bounds", "unit: J}", "upper: 3}", "integrals.work.upper", 'unknown key "upper"'),
    edit(
        "a list of integrals",
        "  spent: u**2",
        "  spent: [u**2]",
        "integrals.spent",
        "must be a number or an expression",
    ),
    edit("an integral of abs", "spent: u**2", "spent: abs(u)", "integrals.spent", "abs is not a consistent function"),
]
