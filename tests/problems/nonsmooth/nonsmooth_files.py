"""Problem files with abs, min and max, and their solutions."""

from trajopt.problems.build import build, build_all
from trajopt.problems.load import load_text
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve

FILE = """\
trajopt: 1
parameters: {{k: 2.0, n: -1.0}}
expressions: {{{expressions}}}
time: {{initial: 0, final: 1}}
states:
  x: {{rate: v, initial: 0, final: 1}}
  v: {{rate: "{rate}", lower: -9, upper: 9{ends}}}
controls: {{u: {{lower: -50, upper: 50}}, w: {{lower: 0, upper: 1}}}}
optimize: {{p: {{lower: -1, upper: 1}}}}
objective: {{{objective}}}
nonsmooth: {nonsmooth}
constraints: {{{constraints}}}
mesh: [{{method: trapezoid, {mesh}]
"""
REST = ", initial: 0, final: 0"
COST = "minimize: {integral: u**2 + w + p**2}"


def text(
    *, nonsmooth="slack", rate="u", objective=COST, constraints="", expressions="", ends="", mesh="segments: 20}"
) -> str:
    return FILE.format(
        nonsmooth=nonsmooth,
        rate=rate,
        objective=objective,
        constraints=constraints,
        expressions=expressions,
        ends=ends,
        mesh=mesh,
    )


def loaded(**parts):
    return load_text(text(**parts), "file.yaml")


def result(spec, mesh=None):
    problems = build_all(spec) if mesh is None else build(spec)
    solution = solve(problems, mesh or steps(spec.mesh), Settings(spec.solver.options))
    assert solution.solved, solution.status
    return solution
