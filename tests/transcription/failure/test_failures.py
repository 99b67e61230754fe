"""What cannot be solved is explained in the user's terms: which constraint or expression, when, with which values."""

import json
import re
import warnings

import pytest
from command_line import trajopt
from named import crossed, share

from trajopt.cli.errors import TOLERANCE_MISSED
from trajopt.problems.build import build
from trajopt.problems.load import load_text
from trajopt.transcription.engines.ipopt import DEFAULTS
from trajopt.transcription.engines.watch import Watch
from trajopt.transcription.one_mesh import Origin, solve_mesh
from trajopt.transcription.schemes.table import METHODS
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve

BLOCK = "x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}"
LINE = "x: {rate: u, initial: 0, final: 1}"


def problem(
    *,
    states=BLOCK,
    u="lower: -10, upper: 10",
    objective="integral: u**2",
    extra="",
    final="1",
    method="hermite-simpson",
    segments=10,
) -> str:
    return f"""\
trajopt: 1
name: a failure
time: {{initial: 0, final: {final}}}
states: {{{states}}}
controls: {{u: {{{u}}}}}
objective: {{minimize: {{{objective}}}}}
{extra}
mesh: [{{method: {method}, segments: {segments}}}]
"""


def failed(text: str, **options):
    spec = load_text(text, "failure.yaml")
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # NumPy's would reach the user's terminal
        problem = build(spec)
        own = [phase.guess for phase in problem.phases]  # given as a guess: no other start is tried
        solution = solve(problem, steps(spec.mesh), Settings({**spec.solver.options, **options}), guess=own)
    assert not solution.solved
    assert solution.status.message and solution.status.remedy
    return solution


def failed_mesh(text: str):
    """As `failed`, on the mesh alone: to find what would have to give way, as test_explain does, takes most time."""
    spec = load_text(text, "failure.yaml")
    (step,), settings = steps(spec.mesh), Settings(spec.solver.options)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        problem = build(spec)
        own = Origin([phase.guess for phase in problem.phases], None)
        solution, _ = solve_mesh(problem, [step.mesh()], DEFAULTS["tol"], settings, own, Watch(None, None, 0))
    assert not solution.solved
    assert solution.status.message and solution.status.remedy
    return solution


PATH = "constraints: {path: [{name: speed limit, expression: v, upper: 0.5}]}"

INFEASIBLE = {
    "a boundary constraint": (
        problem(extra='constraints: {boundary: [{name: too fast, expression: "v[final] - v[initial]", equals: 3}]}'),
        ["boundary constraint 'too fast'", "the initial value of v", "the final value of v"],
        "boundary constraint 'too fast' missed by 3.00e+00",
    ),
    "a path constraint": (
        problem(extra=PATH),
        ["path constraint 'speed limit' between t = 0.1 and 0.9", "the final value of x"],
        "the dynamics of x between t = ",
    ),
    "a path constraint, compressed": (
        problem(extra=PATH, method="hermite-simpson-compressed"),
        ["path constraint 'speed limit' between t = 0.1 and 0.9", "the final value of x"],
        "the dynamics of x between t = ",
    ),
    "a path constraint at one time": (
        problem(
            extra="constraints: {path: [{name: early, expression: x + (t - 0.5)**2 + p, upper: 0.2}]}\n"
            "optimize: {p: {lower: 0, upper: 1}}"
        ),
        ["path constraint 'early'"],
        "path constraint 'early' at t = ",
    ),
    "an integral constraint": (
        problem(extra="constraints: {integral: [{name: fuel, expression: u**2, upper: 1}]}"),
        ["integral constraint 'fuel'", "the initial value of x", "the final value of x"],
        "the dynamics of x",
    ),
    "bounds of a control": (
        problem(u="lower: -1, upper: 1"),
        ["the upper bound of u between t = 0 and 0.45", "the lower bound of u between t = 0.55 and 1"],
        "the dynamics of x",
    ),
    "bounds of a state": (
        problem(states="x: {rate: v, initial: 0, final: 1}, v: {rate: u, upper: 0.5, initial: 0, final: 0}"),
        ["the upper bound of v between t = ", "the final value of x"],
        "the dynamics of x",
    ),
    "bounds of a state, compressed": (
        problem(
            states="x: {rate: v, initial: 0, final: 1}, v: {rate: u, upper: 0.5, initial: 0, final: 0}",
            method="hermite-simpson-compressed",
        ),
        ["the upper bound of v between t = ", "the final value of x"],
        "the dynamics of x",
    ),
    "uncontrolled dynamics": (
        problem(states="x: {rate: -x, initial: 0, final: 1}"),
        ["the initial value of x", "the final value of x"],
        "the dynamics of x",
    ),
}


@pytest.mark.parametrize("case", INFEASIBLE)
def test_constraints_that_contradict_each_other(case):
    text, conflict, missed = INFEASIBLE[case]
    solution = failed_mesh(text)
    assert solution.status.name in ("INFEASIBLE", "OVERDETERMINED")
    assert solution.trouble.startswith("these cannot all hold: ")
    for part in conflict:
        assert part in solution.trouble
    assert missed in str(solution.violations[0])
    amounts = [violation.amount for violation in solution.violations]
    assert amounts == sorted(amounts, reverse=True) and amounts[-1] > 1e-7


@pytest.mark.parametrize(
    "method", share([name for name in METHODS if name != "finite-difference"], 3)
)  # it needs accel:
def test_every_method_names_the_constraint(method):
    solution = failed_mesh(problem(extra=PATH, method=method, segments=5))
    named = solution.trouble.removeprefix("these cannot all hold: ").split(", ")
    ends, over_time = [n for n in named if " value of " in n], [n for n in named if " between " in n]
    assert "the final value of x" in ends and named[: len(ends)] == ends  # what is demanded once is named first
    assert re.match(r"path constraint 'speed limit' between t = 0\.\d+ and 0\.[89]", over_time[0])


def test_what_does_not_act_is_not_named():
    loose = PATH.replace("]}", ", {name: loose, expression: v, lower: -50}]}")
    assert "loose" not in failed_mesh(problem(extra=loose)).trouble


NOT_FINITE = {
    "log of a negative": (
        problem(states="x: {rate: v, initial: 0, final: 1}, v: {rate: u + log(x - 0.5), initial: 0, final: 0}"),
        'rate of v: "log(x - 0.5)" is not a real number at t = 0, where x = 0',
    ),
    "division by zero": (
        problem(states="x: {rate: v/x, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}"),
        'rate of x: "v/x" divides by zero at t = 0, where v = 0, x = 0',
    ),
    "division by zero in the middle": (
        problem(states="x: {rate: u + 0.01/(x - 0.5), initial: 0, final: 1}"),
        'rate of x: "0.01/(x - 0.5)" divides by zero at t = 0.5, where x = 0.5',
    ),
    "division by time": (
        problem(states="x: {rate: v, initial: 0, final: 1}, v: {rate: u/t, initial: 0, final: 0}"),
        'rate of v: "u/t" divides by zero at t = 0, where u = 0',
    ),
    "a divisor that cancels": (
        problem(states="x: {rate: u + 1/(x - x), initial: 0, final: 1}"),
        'rate of x: "1/(x - x)" divides by zero at t = 0, where x = 0',
    ),
    "overflow": (
        problem(states="x: {rate: u + exp(exp(10*x)), initial: 0, final: 1}"),
        'rate of x: "exp(exp(10*x))" is too large a number at t = 0.7, where x = 0.7',
    ),
    "in a named expression": (
        problem(
            states="x: {rate: u + root, initial: 0, final: 1}", extra="expressions: {part: x - 1, root: sqrt(part)}"
        ),
        'rate of x: "sqrt(part)" is not a real number at t = 0, where part = -1',
    ),
    "in the objective": (
        problem(states=LINE, objective="integral: u**2/x"),
        'integral objective: "u**2/x" divides by zero at t = 0, where u = 0, x = 0',
    ),
    "in the terminal objective": (
        problem(states="x: {rate: u, initial: 0}", objective='integral: u**2, terminal: "log(x[final])"'),
        'terminal objective: "log(x[final])" is the logarithm of zero, where x[final] = 0',
    ),
    "in a path constraint": (
        problem(states=LINE, extra="constraints: {path: [{name: p, expression: sqrt(x - 0.5), lower: -1}]}"),
        "path constraint 'p': \"sqrt(x - 0.5)\" is not a real number at t = 0, where x = 0",
    ),
    "in a boundary constraint": (
        problem(extra='constraints: {boundary: [{name: b, expression: "log(v[final] - 1)", upper: 3}]}'),
        "boundary constraint 'b': \"log(v[final] - 1)\" is not a real number, where v[final] = 0",
    ),
    "in an integral constraint": (
        problem(states=LINE, extra="constraints: {integral: [{name: i, expression: 1/x, upper: 3}]}"),
        "integral constraint 'i': \"1/x\" divides by zero at t = 0, where x = 0",
    ),
    "a derivative": (
        problem(states="x: {rate: sqrt(v), initial: 0, final: 1}, v: {rate: u, initial: 0, final: 1}"),
        'rate of x: the derivative of "sqrt(v)" by v is not finite at t = 0, where v = 0',
    ),
    "a derivative of the objective": (
        problem(states="x: {rate: u, initial: 0}", objective='integral: u**2, terminal: "sqrt(x[final])"'),
        'terminal objective: the derivative of "sqrt(x[final])" by x[final] is not finite, where x[final] = 0',
    ),
    "a second derivative": (
        problem(states="x: {rate: u + x**1.5, initial: 0, final: 1}"),
        'rate of x: the second derivative of "u + x**1.5" by x is not finite at t = 0, where x = 0, u = 0',
    ),
    "a derivative by a free time": (
        problem(states="x: {rate: u*sqrt(t), initial: 0, final: 1}", final="{lower: 0.5, upper: 2, guess: 1}"),
        'rate of x: the derivative of "u*sqrt(t)" by t is not finite at t = 0, where u = 0',
    ),
}


EVERYWHERE = [case for case in NOT_FINITE if case not in ("overflow", "a derivative by a free time")]
"""Those whose first point without a value is one of every method."""


@pytest.mark.parametrize(
    ("case", "method"),
    [(case, "hermite-simpson") for case in NOT_FINITE]
    + crossed(EVERYWHERE, ["trapezoid", "hermite-simpson-compressed"]),
)
def test_a_function_without_a_value(case, method):
    text, sentence = NOT_FINITE[case]
    solution = failed(text.replace("hermite-simpson", method))
    assert solution.status.name == "INVALID_NUMBER"
    assert solution.trouble == sentence
    assert not solution.violations  # those of the guess are not why


def test_a_bound_that_ipopt_relaxes():
    solution = failed(problem(states=LINE, u="lower: 0, upper: 10", objective="integral: sqrt(u)"))
    assert 'integral objective: "sqrt(u)" is not a real number at t = ' in solution.trouble
    assert "bound_relax_factor: 0" in solution.trouble


def test_iteration_limit():
    solution = failed(problem(states="x: {rate: u*x + sin(5*x), initial: 1, final: 3}"), max_iter=1)
    assert solution.status.name == "MAX_ITERATIONS" and "max_iter" in solution.status.remedy
    assert str(solution.violations[0]).startswith("the dynamics of x between t = ")
    assert solution.trouble == ""


def test_more_equations_than_unknowns():
    both = "constraints: {path: [{name: a, expression: u - x, equals: 0}, {name: b, expression: u - v, equals: 0}]}"
    solution = failed(problem(extra=both))
    assert solution.status.name == "OVERDETERMINED"
    assert solution.trouble == (
        "82 equations for 59 unknowns: 20 from the dynamics of x, 20 from the dynamics of v, "
        "21 from path constraint 'a', 21 from path constraint 'b'"
    )


@pytest.mark.parametrize("objective", ["integral: u", "terminal: 'x[final]'"])
def test_unbounded(objective):
    solution = failed(problem(states="x: {rate: u, initial: 0}", u="", objective=objective), max_iter=200)
    assert solution.status.name in ("DIVERGING", "MAX_ITERATIONS")
    assert solution.objective < -1e10
    assert solution.trouble.startswith("u runs to -")
    assert "bounds" in solution.trouble and "objective" in solution.trouble


def test_redundant_constraints_are_no_failure():
    twice = ", ".join(f'{{name: {n}, expression: "x[final] - x[initial]", equals: 1}}' for n in "ab")
    spec = load_text(problem(extra=f"constraints: {{boundary: [{twice}]}}"), "twice.yaml")
    solution = solve(build(spec), steps(spec.mesh))
    assert solution.solved and solution.objective == pytest.approx(12)


@pytest.mark.usefixtures("folder")
@pytest.mark.parametrize("accept", ["optimal", "acceptable"])
def test_acceptable_level(accept):
    loose = ("acceptable_tol", "acceptable_constr_viol_tol", "acceptable_dual_inf_tol", "acceptable_compl_inf_tol")
    options = [f"solver.{name}=1e2" for name in loose] + ["solver.acceptable_iter=1", f"solver.accept={accept}"]
    arguments = [argument for option in options for argument in ("--set", option)]
    result = trajopt("solve", "cartpole", "--json", *arguments)
    summary = json.loads(result.stdout)
    assert summary["status"] == "acceptable"
    assert summary["solved"] is (accept == "acceptable")
    assert result.exit_code == ((TOLERANCE_MISSED if summary["inaccurate"] else 0) if accept == "acceptable" else 1)
    assert "accept: acceptable" in summary["remedy"]


@pytest.mark.parametrize("case", ["log of a negative", "a derivative", "division by time"])
def test_the_table_explains_and_the_file_is_written(case, folder):
    text, sentence = NOT_FINITE[case]
    (folder / "bad.yaml").write_text(text)
    result = trajopt("solve", "bad.yaml")
    assert result.exit_code == 1
    assert result.stdout.startswith("a failure: NOT SOLVED\n")
    lines = dict(line.split(maxsplit=1) for line in result.stdout.splitlines()[1:])
    assert lines["cause"] == sentence
    assert lines["remedy"].startswith("bound the variables")
    assert result.stderr.startswith("not solved: a failure: ") and result.stderr.count("\n") == 1
    assert sentence in result.stderr
    shown = trajopt("show", "bad.h5")
    assert shown.exit_code == 1 and sentence in shown.stdout


@pytest.mark.parametrize(
    "expression", ["sqrt(a.x[final] - 5) - b.x[initial]", "1/(a.x[final] - a.x[final])", "log(-1 - b.x[initial]**2)"]
)
def test_a_link_without_a_finite_value_is_told(expression, folder):
    """It is between phases, and belongs to none."""
    (folder / "x.yaml").write_text(f"""
trajopt: 1
time: {{initial: 0, final: 2}}
states: {{x: {{rate: u, initial: 0, final: 1}}}}
controls: {{u: {{}}}}
phases: {{a: {{time: {{final: 1}}}}, b: {{}}}}
links: [{{from: a, to: b}}, {{name: jump, expression: "{expression}", lower: -9}}]
objective: {{minimize: {{integral: u**2}}}}
""")
    run = trajopt("solve", "x.yaml")
    assert run.exit_code == 1
    assert "link 'jump': " in run.stdout and "x[" in run.stdout.split("link 'jump': ")[1].splitlines()[0]
