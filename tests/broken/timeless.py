"""Mistakes of problems without time, and of discrete time."""

from .case import edits

STATIC = """\
trajopt: 1
parameters: {c: 3}
optimize:
  x1: {guess: 1}
  x2: {guess: 2}
objective: {minimize: x1**2 + x2**2}
constraints:
  - {name: hyperbola, expression: x1*x2, equals: c}
  - {expression: x1, lower: 0}
"""

DISCRETE = """\
trajopt: 1
time: {initial: 0, final: 10}
states:
  x: {next: x + v, initial: 0, final: 1}
  v: {next: v + u, initial: 0, final: 0}
controls:
  u: {lower: -1, upper: 1}
objective: {minimize: {sum: u**2}}
constraints:
  sum: [{name: effort, expression: u**2, upper: 5}]
"""

static, discrete = edits(STATIC), edits(DISCRETE)

TIMELESS = [
    static("static: an unknown name", "x1*x2", "x1*y", "constraints.0.expression", 'unknown name "y"'),
    static("static: time in it", "x1*x2", "x1*t", "constraints.0.expression", 'unknown name "t"'),
    static("static: an end", "x1*x2", "'x1[final]'", "constraints.0.expression", "has only one value; write x1"),
    static("static: a bound of nothing", ", lower: 0", "", "constraints.1", "the constraint has no bound"),
    static("static: a wrong objective", "x1**2 + x2**2", "x1**2 +", "objective.minimize", "the expression ends with +"),
    static(
        "static: an integral", "x1**2 + x2**2", "{integral: x1}", "objective.minimize.integral", "no time to integr"
    ),
    static(
        "static: a mesh",
        "trajopt: 1",
        "trajopt: 1\nmesh: [{method: gauss, segments: 3}]",
        "mesh",
        "has no mesh",
        line=2,
    ),
    static(
        "static: refined", "trajopt: 1", "trajopt: 1\nrefine: {}", "refine", "nothing in it is approximated", line=2
    ),
    static(
        "static: measurements",
        "trajopt: 1",
        "trajopt: 1\nmeasurements: {m: {data: {time: [0, 1], y: [1, 2]}}}",
        "measurements.m",
        "no time at which anything is measured",
        line=2,
    ),
    discrete(
        "discrete: another kind of state", "next: v + u", "rate: u", "states.v", "time is discrete, as other states"
    ),
    discrete(
        "discrete: rate and next", "next: v + u", "next: v + u, rate: u", "states.v", "rate and next are both given"
    ),
    discrete(
        "discrete: accel and next", "next: v + u", "next: v, accel: u", "states.v", "next and accel are both given"
    ),
    discrete("discrete: an unknown name", "next: v + u", "next: v + w", "states.v.next", 'unknown name "w"'),
    discrete("discrete: half a step", "final: 10", "final: 10.5", "time.final", "is the number of a step, not 10.5"),
    discrete("discrete: a free end", "final: 10", "final: {lower: 3, upper: 9}", "time.final", "and cannot be free"),
    discrete("discrete: too many steps", "final: 10", "final: 1.0e+7", "time.final", "1e+07 steps are asked for"),
    discrete("discrete: the sum of nothing", "sum: u**2", "sum: w**2", "objective.minimize.sum", 'unknown name "w"'),
    discrete("discrete: a sum of a wrong bound", "upper: 5", "upper: b", "constraints.sum.0.upper", 'unknown name "b"'),
    discrete(
        "discrete: a mesh",
        "trajopt: 1",
        "trajopt: 1\nmesh: [{method: gauss, segments: 3}]",
        "mesh",
        "discrete time has no mesh",
        line=2,
    ),
]
