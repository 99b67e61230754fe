"""Problem files as texts, for the tests of `import trajopt`."""

BLOCK = """
trajopt: 1
name: block
time: {initial: 0, final: 1}
parameters: {m: {value: 2, unit: kg}, far: 1}
optimize: {k: {lower: 1, upper: 5, guess: 2}}
states:
  x: {unit: m, rate: v, initial: 0, final: far}
  v: {unit: m/s, rate: u/m, initial: 0, final: 0}
controls: {u: {unit: N, lower: -100, upper: 100}}
expressions: {power: u*v, twice: 2*m, size: abs(u)}
objective: {minimize: {integral: u**2, terminal: (k - 3)**2}}
nonsmooth: slack
mesh: [{method: hermite-simpson, segments: 8}]
"""
ALGEBRAIC = """
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: z, initial: 0, final: 1}}
controls: {u: {}}
algebraic: {z: {unit: m/s}}
residuals: [z - u]
objective: {minimize: {integral: u**2}}
mesh: [{method: gauss, degree: 3, segments: 4}]
"""
