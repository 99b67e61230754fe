"""Mistakes with vectors: wrong lengths, unknown components, a vector where one value is meant."""

from .case import edits

WITH_VECTORS = """\
trajopt: 1
parameters: {J: [1, 2, 3], m: 2, e: [1, 0]}
time: {initial: 0, final: 1}
expressions:
  half(a): a/2
  spin: "cross(r, v)"
states:
  r: {size: 3, rate: v, initial: 0, final: [1, 0, 0]}
  v: {size: 3, rate: "F/m - half(v)", initial: 0, final: 0}
  x: {rate: "dot(v, spin)/J[1] + e[2]", initial: 0}
controls:
  F: {size: 3, unit: N, lower: -10, upper: 10}
objective: {minimize: {integral: "dot(F, F)"}}
constraints:
  path:
    - {name: near, expression: r, upper: 5}
guess: {constants: {F: [0, 0, 1]}}
"""
edit = edits(WITH_VECTORS)

ONE_VALUE = "has to be one value; name a component, as in q[1], or write dot(a, a), norm(a) or sum(a)"


def rate(name: str, given: str, says: str):
    return edit(name, '"F/m - half(v)"', f"'{given}'", "states.v.rate", says)


def objective(name: str, given: str, says: str):
    return edit(name, "dot(F, F)", given, "objective.minimize.integral", says)


def size(name: str, given: str, says: str):
    return edit(name, "r: {size: 3", f"r: {{size: {given}", "states.r.size", says)


def final(name: str, given: str, place: str, says: str):
    return edit(name, "final: [1, 0, 0]", f"final: {given}", f"states.r.{place}", says)


VECTORS = [
    edit(
        "a range as a text",
        '+ e[2]", initial: 0',
        '+ e[2]", initial: "[0, m]"',
        "states.x.initial",
        "a range is no list; write initial: {lower: 0, upper: m}",
    ),
    edit(
        "a range of numbers as a text",
        '+ e[2]", initial: 0',
        '+ e[2]", final: "[-1, 1]"',
        "states.x.final",
        "a range is no list; write final: {lower: -1, upper: 1}",
    ),
    rate("vectors of two lengths", "F + e", '"F + e": a vector of 3 and a vector of 2 do not go together'),
    rate("a cross product in the plane", "cross(e, e)", "cross takes a vector of 3, and e is a vector of 2; write "),
    rate("a component beyond the last", "F*v[4]", '"v[4]": v has the components v[1] to v[3]'),
    rate("a component before the first", "F*v[0]", '"v[0]": v has the components v[1] to v[3]'),
    rate("a component of one value", "F*m[1]", "for a component make m a vector, by size: 3"),
    rate("a slice of a vector", "r[1:3]", "write r[1..3], with both ends included"),
    rate("a scalar rate of a vector", "dot(F, v)", "this is one value, and has to be a vector of 3"),
    rate("a rate of the wrong length", "[F[1], F[2]]", "v is a vector of 3, and its rate a vector of 2; write size: 2"),
    rate("a list that is no matrix", "[[1, 2], 3] @ e", "the items of this list are not alike"),
    rate(
        "a product of the wrong length",
        "[[1, 2], [3, 4]] @ F",
        "a matrix of 2 by 2 and a vector of 3 have no product @",
    ),
    rate(
        "a matrix times a vector by *",
        "[[1, 2], [3, 4]]*e",
        "are multiplied by @, and * goes element by element; write [[1, 2], [3, 4]] @ e",
    ),
    rate("dot of a number", "F*dot(m, F)", "dot takes vectors, and m is one value; write dot(a, b); a state or"),
    rate("dot of one vector", "F*dot(F)", "dot takes 2 arguments, not 1"),
    rate("a quaternion of three", "quat_mul(F, F)", "quaternions whose scalar part is last"),
    rate("a vector with a slip", "F^2", "^ is not the power operator"),
    rate("a component with a slip", "2 F[1]", "an operator is missing"),
    rate("a method of a vector", "F.dot(r)*F", "expressions know no modules and no attributes"),
    rate("an unknown name among vectors", "F*k", 'unknown name "k"'),
    rate("a function with too many vectors", "half(F, v)", "half takes 1 argument, not 2; write half(a)"),
    rate("a sum of one value", "F*sum(m)", "a sum is over a loop or over a vector"),
    objective("a vector as objective", "F", f"this is a vector of 3, and {ONE_VALUE}"),
    objective("a square of a vector as objective", "F**2", f"this is a vector of 3, and {ONE_VALUE}"),
    size("a vector of no components", "0", "the size is 0; write whole numbers from 1 to 100"),
    size("a size that is unknown", "M", "M is no parameter that is a whole number"),
    size("a size that is no number", "true", "this is no size; write a whole number, size: 3"),
    final("an end of the wrong length", "[1, 0]", "final", "this is a list of 2, and has to be a vector of 3"),
    final("an end by a vector of the wrong length", "e", "final", "this is a vector of 2, and has to be a vector of 3"),
    final("a mistake in one component", "[1, {lowr: 0}, 0]", "final.1.lowr", 'unknown key "lowr"'),
    final("bounds of the wrong length", "{lower: [1, 2]}", "final.lower", "a list of 2, and has to be a vector of 3"),
    edit("rates of a scalar", '"dot(v, spin)/J[1] + e[2]"', "[1, 2]", "states.x.rate", "write size: 2 beside it"),
    edit("a bound of the wrong length", "r, upper: 5", "r, upper: [5, 6]", "constraints.path.0.upper", "a list of 2"),
    edit("a guess of the wrong length", "[0, 0, 1]", "[0, 1]", "guess.constants.F", "has to be a vector of 3"),
    edit("units of the wrong length", "unit: N", "unit: [N, N]", "controls.F.unit", "there are 2 units"),
    edit("a component that is declared, too", "x: {rate", "r2: {rate", "states.r", "r has the component r2", line=8),
    edit(
        "a vector made of itself",
        "half(a): a/2",
        "half(a): a/2\n  A: spin + B\n  B: A",
        "expressions.B",
        "itself",
        line=7,
    ),
]
