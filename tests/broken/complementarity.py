"""Mistakes of pairs that are never both above zero."""

from .case import edits

BLOCK = """trajopt: 1
name: a block on the ground
parameters: {g: 9.81}
time: {initial: 0, final: 2}
states:
  y: {unit: m, rate: v, initial: 1, final: 0}
  v: {unit: m/s, rate: u + f - g, initial: 0, final: 0}
controls: {u: {}, f: {upper: 100}}
constraints:
  path: [{name: speed, expression: v**2, upper: 90}]
complementarity:
  - {name: ground, a: y, b: f, relax: [1, 0.01, 1.0e-4]}
objective: {minimize: {integral: u**2}}
mesh: [{method: implicit-euler, segments: 20}]
"""

PAIR = "{name: ground, a: y, b: f, relax: [1, 0.01, 1.0e-4]}"

pair = edits(BLOCK)


def other(name, entry, key, says):
    """The block with another pair."""
    return pair(name, PAIR, entry, f"complementarity.0{key}", says)


COMPLEMENTARITY = [
    other("a pair of an unknown name", "{a: y, b: force}", ".b", 'unknown name "force"'),
    other("a pair of one", "{a: y}", ".b", "missing"),
    other("a pair that is no mapping", "y*f", "", "must be a mapping"),
    other("a pair with a strange key", "{a: y, b: f, eps: 1}", ".eps", "unknown key"),
    other("a pair of one thing", "{a: y, b: y}", ".b", "both are zero"),
    other("a pair with a constant", "{a: y, b: 2*g}", ".b", "is a constant"),
    other("a pair at an end", "{a: 'y[final]', b: f}", ".a", "value at one end"),
    other("a pair relaxed to nothing", "{a: y, b: f, relax: [1, 0]}", ".relax", "write positive numbers"),
    other("a pair relaxed upwards", "{a: y, b: f, relax: [1.0e-4, 1]}", ".relax", "do not go down"),
    other("a pair without steps", "{a: y, b: f, relax: []}", ".relax", "at least 1"),
    other("a pair relaxed by a word", "{a: y, b: f, relax: [slowly]}", ".relax.0", "must be a number"),
    other(
        "a pair of a constraint's name", "{name: speed, a: y, b: f}", ".name", 'another constraint is called "speed"'
    ),
    pair(
        "a pair that begins below zero",
        "initial: 1",
        "initial: -1",
        "complementarity.0.a",
        "may not be negative",
        line=12,
    ),
    pair(
        "a pair that is always below zero",
        "{upper: 100}",
        "{upper: -1}",
        "complementarity.0.b",
        "its bounds end at -1",
        line=12,
    ),
    pair("pairs that are no list", "complementarity:\n  - ", "complementarity: ", "complementarity", "must be a list"),
    pair(
        "a pair for Newton",
        "mesh: [{",
        "solver: {engine: newton}\nmesh: [{",
        "complementarity",
        "takes equality",
        line=11,
    ),
]
