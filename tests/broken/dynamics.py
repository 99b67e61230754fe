"""Mistakes of dynamics: accelerations, residuals, models."""

from .case import edit, edits
from .good import ACCEL, IMPLICIT, MODEL

accel, implicit, model = map(edits, (ACCEL, IMPLICIT, MODEL))

DYNAMICS = [
    edit(
        "rate and accel", "rate: v,", "rate: v, accel: u,", "states.x", "keep the rate, or state the dynamics by accel"
    ),
    edit("rate and velocity", "rate: v,", "rate: v, velocity: {},", "states.x", "rate and velocity are both given"),
    accel("a misspelt accel", "accel:", "acel:", "states.x.acel", "did you mean accel?"),
    accel(
        "no accel",
        "accel: (u - c*v)/m, ",
        "",
        "states.x",
        "accel is missing; add accel: an expression, or residuals:",
    ),
    accel("a velocity of a taken name", "{name: v,", "{name: u,", "states.x.velocity", "already declared"),
    accel("a velocity of no name", "{name: v,", "{name: 2v,", "states.x.velocity", "use a letter"),
    accel("crossed bounds of a velocity", "final: 0}", "lower: 1, upper: 0}", "states.x.velocity.lower", "is above"),
    accel(
        "a velocity out of bounds",
        "final: 0}",
        "upper: 0, final: 1}",
        "states.x.velocity.final",
        "outside the bounds",
    ),
    accel(
        "a velocity that is a number",
        "{name: v, unit: m/s, final: 0}",
        "3",
        "states.x.velocity",
        "must be a mapping",
    ),
    accel("an end in an accel", "(u - c*v)/m", "'u - v[final]'", "states.x.accel", "taken at every time"),
    implicit(
        "too few residuals",
        "  - m*v[rate] - F\n",
        "",
        "residuals",
        "not 1 for 2 algebraic variables (F, v[rate])",
        line=18,
    ),
    implicit(
        "too many residuals",
        "  - m*v[rate] - F\n",
        "  - F\n  - v[rate]\n",
        "residuals",
        "not 3 for 2",
        line=18,
    ),
    implicit(
        "an algebraic variable in no residual",
        "m*v[rate] - F\n  - {name: force, expression: F - u + c*v}",
        "m*v[rate] - u\n  - v[rate]",
        "algebraic.F",
        "stands in no residual",
        line=17,
    ),
    implicit(
        "an implicit state in no residual",
        "m*v[rate] - F",
        "m*v - F",
        "states.v",
        "use v[rate] in residuals:",
        line=13,
    ),
    implicit(
        "the rate of an explicit state",
        "m*v[rate] - F",
        "m*x[rate] - F",
        "states.v",
        "use v[rate] in residuals:",
        line=13,
    ),
    implicit(
        "the rate of an explicit state at an end",
        '"x[final] - x[initial]"',
        '"x[final] - x[rate]"',
        "constraints.boundary.0",
        "leave out rate: of x",
    ),
    implicit("the rate of a control", "m*v[rate] - F", "m*u[rate] - F", "residuals.0", "only a state without rate:"),
    implicit(
        "the acceleration of a state",
        "m*v[rate] - F",
        "v[accel]",
        "residuals.0",
        "write v[initial] or v[final]",
    ),
    implicit(
        "a rate at the ends",
        "x[final] - x[initial]",
        "v[rate]",
        "constraints.boundary.0",
        "under expressions:",
    ),
    implicit("a residual without expression", "expression: F - u + c*v", "", "residuals.1", "expression is missing"),
    implicit("a residual that is a list", "- m*v[rate] - F", "- [1]", "residuals.0", "a number or an expression"),
    implicit("residuals as a mapping", "residuals:\n", "residuals: {a: 1}\nno:\n", "residuals", "must be a list"),
    implicit("two residuals of one name", "name: force", "name: speed limit", "residuals.1.name", "its own name"),
    implicit(
        "a rate of an algebraic variable",
        "{unit: N}\nres",
        "{rate: u}\nres",
        "algebraic.F.rate",
        "unknown key",
    ),
    implicit(
        "an algebraic name twice",
        "  F: {unit: N}\n",
        "  F: {}\n  d: {}\n",
        "algebraic.d",
        "already declared under parameters",
        line=18,
    ),
    edit(
        "algebraic without residuals",
        "optimize:",
        "algebraic: {F: {}}\noptimize:",
        "algebraic.F",
        "nothing determines F",
    ),
]

MODELS = [
    model("an unknown model", "five_link_biped", "five_link_bipped", "model", "did you mean five_link_biped?"),
    model(
        "a parameter of a model missing",
        "  m5: m1\n",
        "",
        "parameters",
        "needs the parameter m5, mass of the swing tibia",
        line=10,
    ),
    model(
        "an unknown key beside a name",
        "model: five_link_biped",
        "model: {kind: five_link_biped, base: cart}",
        "model",
        "takes no keys here",
        line=9,
    ),
    model(
        "a name of a model",
        "constraints:\n  path:",
        "expressions: {foot_x: 1}\nconstraints:\n  path:",
        "expressions.foot_x",
        "foot_x is a name of the model five_link_biped; choose another name",
    ),
    model("an unknown name beside a model", "u5**2", "uu5**2", "objective.minimize.integral", "did you mean u5?"),
    model("a guess that a model has not", "    dq5: (", "    dq6: (", "guess.constants.dq6", "did you mean dq5?"),
    edit("a file without states or model", "states:", "states_:", "states_", "did you mean states?"),
]
