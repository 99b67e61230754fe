"""Mistakes in functions of the file: how they are declared, and how they are called."""

from .case import edits
from .good import GOOD

WITH_FUNCTIONS = GOOD.replace(
    "  power: u*v\n",
    "  power: u*v\n"
    "  drag(a, h): 0.1*m*a**2*exp(-h)\n"
    "  twice(a): {value: 2*a, note: two of them}\n"
    "  braked(a): drag(a, d) + twice(c)\n"
    "  pull(a): a*v\n",
).replace(
    "(u - c*v)/m, initial: 0, final: 0", "'(u - c*v - drag(v, x) - braked(v) - twice(power))/m', initial: 0, final: 0"
).replace("x[final]*v[final] + c**2", "x[final]*v[final] + drag(v[final], x[final]) + pull(v[final])")  # fmt: skip
edit = edits(WITH_FUNCTIONS)


def declared(name: str, signature: str, says: str):
    return edit(name, "  drag(a, h):", f"  {signature}:", f"expressions.{signature}", says)


def called(name: str, call: str, says: str):
    return edit(name, "drag(v, x)", call, "states.v.rate", says)


def ended(name: str, call: str, says: str):
    return edit(name, "pull(v[final])", call, "objective.minimize.terminal", says)


FUNCTIONS = [
    called("too few arguments", "drag(v)", "drag takes 2 arguments, not 1; write drag(a, h)"),
    called("too many arguments", "drag(v, x, m)", "drag takes 2 arguments, not 3; write drag(a, h)"),
    called("a function by its name alone", "drag", "drag is a function; give it its arguments: drag(a, h)"),
    called("a call of what is no function", "power(v)", "power is not a function; write power*(...) for a product"),
    called("a misspelt function", "darg(v, x)", "there is no darg(...); did you mean drag?"),
    called("an argument that nobody knows", "drag(v, y)", 'unknown name "y"'),
    called("a call without arguments", "drag()", "there is nothing between the parentheses"),
    called("an end of a call", "drag(v, x)[final]", "an end of time after each name in it"),
    called("the name of an argument outside of its function", "drag(v, x)*h", 'unknown name "h"'),
    declared("an argument twice", "drag(h, h)", "drag has two arguments h; give each a name of its own"),
    declared("an argument that is a number", "drag(a, 2)", 'argument 2 of drag: "2" cannot be a name'),
    declared("an argument that is a function", "drag(a, exp)", 'argument 2 of drag: the name "exp" has a meaning'),
    declared("an argument that is the time", "drag(a, t)", 'argument 2 of drag: the name "t" has a meaning'),
    declared("a function with no arguments", "drag()", "drag has no arguments; write drag alone"),
    declared("a function like another one of the language", "sin(a, h)", 'the name "sin" has a meaning of its own'),
    edit(
        "a function that is a state",
        "  x: {unit: m, rate",
        "  pull: {unit: m, rate: v}\n  x: {unit: m, rate",
        "states.pull",
        "pull is already declared under expressions",
    ),
    edit(
        "two functions of one name",
        "twice(a): {",
        "twice(a, h): a*h\n  twice(a): {",
        "expressions.twice(a)",
        "twice is already declared under expressions",
        line=12,
    ),
    declared("a parenthesis that is open", "drag(a, h", "cannot be a name, nor a name with arguments"),
    edit(
        "a function that calls itself", "0.1*m*a**2", "drag(a, h)", "expressions.drag(a, h)", "drag -> drag is a circle"
    ),
    edit(
        "a circle of functions",
        "{value: 2*a,",
        "{value: braked(a),",
        "expressions.braked(a)",
        "is a circle: each",
        line=12,
    ),
    edit("a body with an unknown name", "a*v\n", "a*vv\n", "expressions.pull(a)", 'unknown name "vv"; did you mean v?'),
    edit("an argument at an end", "a*v\n", "a[final]*v\n", "expressions.pull(a)", "a is an argument here, and has one"),
    edit("a body at an end", "a*v\n", "a*x[final]\n", "expressions.pull(a)", "this expression is taken at every time"),
    ended("a function over time at the ends", "pull(2)", "v has a value at every time, but this expression is about"),
    ended("a function at two ends", "pull(v[final] - x[initial])", "uses v, and it is not clear at which end"),
    edit(
        "abs in a function",
        "a*v\n",
        "abs(a)*v\n",
        "objective.minimize.terminal",
        "abs is not a consistent function",
        line=22,
    ),
]
