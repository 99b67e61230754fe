"""Good problem files, to be broken by small edits."""

from repository import ROOT

GOOD = """\
trajopt: 1
name: a good file
parameters:
  m: {value: 2.0, unit: kg}
  u_max: 5
  d: 1.0
  T: 2*d
expressions:
  power: u*v
time: {initial: 0, final: T}
states:
  x: {unit: m, rate: v, lower: -2, upper: 2, initial: 0, final: d}
  v: {unit: m/s, rate: (u - c*v)/m, initial: 0, final: 0}
controls:
  u: {note: force, lower: -u_max, upper: u_max}
optimize:
  c: {lower: 0.1, upper: 0.5, guess: 0.3}
objective: {minimize: {integral: u**2, terminal: "x[final]*v[final] + c**2"}}
constraints:
  path:
    - {name: speed limit, expression: v, upper: 3}
  boundary:
    - {expression: "x[final] - x[initial]", equals: d}
  integral:
    - {expression: power, upper: 100}
guess:
  constants: {u: 1}
  keyframes: {time: [0, 1, 2], x: [0, 0.5, 1]}
mesh:
  - {method: hermite-simpson, segments: 10, tolerance: 1e-8}
solver: {max_iter: 100}
reference: {objective: 6.0, tolerance: 1e-6}
"""

IMPLICIT = GOOD.replace("rate: (u - c*v)/m, ", "").replace(
    "optimize:",
    "algebraic:\n  F: {unit: N}\nresiduals:\n  - m*v[rate] - F\n  - {name: force, expression: F - u + c*v}\noptimize:",
)
ACCEL = (
    GOOD.replace("rate: v,", "accel: (u - c*v)/m, velocity: {name: v, unit: m/s, final: 0},")
    .replace("  v: {unit: m/s, rate: (u - c*v)/m, initial: 0, final: 0}\n", "")
)  # fmt: skip
NONSMOOTH = GOOD.replace("integral: u**2", "integral: abs(u*v)").replace("guess:\n", "nonsmooth: slack\nguess:\n")
MODEL = (ROOT / "problems" / "biped_supplement.yaml").read_text()
