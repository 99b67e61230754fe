"""Problems with tables of data, solved: against the same problem by formulas, and at the ends of the points."""

import command_line
import numpy as np
import pytest
from named import problem_named

import trajopt
from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.names.lookups import tables_of
from trajopt.problems.probe import depends_on, names_asked
from trajopt.problems.quantities import Range

PROBLEM = """\
trajopt: 1
name: a block in a medium
parameters: {{k: 0.5}}
{tables}
time: {{initial: 0, final: 1}}
states:
  x: {{unit: m, rate: v, initial: 0, final: 1}}
  v: {{unit: m/s, rate: "{rate}", initial: 0, final: 0}}
controls: {{u: {{}}}}
objective: {{minimize: {{integral: u**2}}}}
{more}
"""
MESH = "mesh: [{method: hermite-simpson, segments: 20}]"
NEVER = "{points: {a: [0, 1]}, values: [0, 1]}"


def text(rate, more=MESH, **tables):
    lines = "".join(f"  {name}: {entry}\n" for name, entry in tables.items())
    return PROBLEM.format(rate=rate, tables=f"tables:\n{lines}" if tables else "", more=more)


def entry(points, function, **keys):
    told = "".join(f", {key}: {value}" for key, value in keys.items())
    v = np.asarray(points, float)
    return f"{{points: {{v: {v.tolist()}}}, values: {function(v).tolist()}{told}}}"


def solved(problem):
    solution = trajopt.solve(trajopt.load(problem))
    assert solution.solved
    return solution


@pytest.mark.parametrize("method", ["hermite-simpson", "gauss", "runge-kutta-4", "trapezoid"])
def test_a_table_of_a_cubic_is_the_cubic(method):
    """Cubic splines are exact for cubics: the optimum is that of the formula to rounding."""
    mesh = f"mesh: [{{method: {method}, segments: 10, tolerance: 1e-10}}]"
    table = entry([0, 0.4, 1, 1.5, 3], lambda v: 0.4 * v**2 - 0.1 * v**3, outside="extrapolate")
    by_table = solved(text("u - drag(v)", mesh, drag=table))
    by_formula = solved(text("u - 0.4*v**2 + 0.1*v**3", mesh))
    assert by_table.objective == pytest.approx(by_formula.objective, rel=1e-9)
    assert by_table["u"](0.3) == pytest.approx(by_formula["u"](0.3), abs=1e-6)


def test_a_dense_table_comes_to_the_function_that_it_samples():
    exact = solved(text("u - exp(-v)")).objective
    errors = []
    for n in (5, 9, 17):
        table = entry(np.linspace(-0.5, 2.5, n), lambda v: np.exp(-v))
        errors.append(abs(solved(text("u - f(v)", f=table)).objective - exact))
    assert errors[0] > 4 * errors[1] > 16 * errors[2] and errors[2] < 1e-4


def test_two_arguments_nested_in_expressions():
    v, x = np.linspace(0, 2, 5), np.linspace(0, 1, 4)
    values = (np.add.outer(v**2, x**3)).tolist()
    table = f"{{points: {{v: {v.tolist()}, x: {x.tolist()}}}, values: {values}, outside: extrapolate}}"
    by_table = solved(text("u - k*sin(f(v, x**2))", f=table))
    by_formula = solved(text("u - k*sin(v**2 + x**6)"))
    assert by_table.objective == pytest.approx(by_formula.objective, rel=1e-8)


def test_error_bounds_a_state_that_is_an_argument():
    table = entry([0, 0.5, 1.2], lambda v: 0.1 * v)
    problem = build(load_text(text("u - f(v)", f=table), "t.yaml"))
    (phase,) = problem.phases
    assert phase.states[1].bounds == Range(0.0, 1.2) and not phase.path
    solution = solved(text("u - f(v)", f=table))
    assert solution["v"](0.5) == pytest.approx(1.2, abs=1e-6)
    free = solved(text("u - f(v)", f=table.replace("]}, ", "]}, outside: extrapolate, ")))
    assert free["v"](0.5) > 1.4 and free.objective < solution.objective


def test_error_constrains_an_expression_that_is_an_argument():
    table = entry([0, 1, 2.4], lambda v: 0.1 * v)
    problem = build(load_text(text("u - f(2*v) - f(2*v)**2", f=table), "t.yaml"))
    (phase,) = problem.phases
    assert [(c.name, c.bounds) for c in phase.path] == [("v of f", Range(0.0, 2.4))]
    assert solved(text("u - f(2*v)", f=table))["v"](0.5) == pytest.approx(1.2, abs=1e-6)


def test_error_at_the_ends_constrains_the_ends_only():
    table = entry([0, 1, 2], lambda v: v)
    more = f"constraints: {{boundary: [{{expression: 'f(v[final]) + f(2*x[final])', upper: 9}}]}}\n{MESH}"
    (phase,) = build(load_text(text("u", more, f=table), "t.yaml")).phases
    assert phase.states[1].final == Range(0.0, 0.0) and phase.states[1].bounds == Range()
    assert [(c.name, c.bounds) for c in phase.boundary][1:] == [("v of f", Range(0.0, 2.0))] and not phase.path


def test_error_on_time_and_on_static_parameters():
    table = entry([0, 1, 2], lambda v: v)
    more = f"optimize: {{p: {{lower: -5, upper: 5}}}}\n{MESH}"
    given = text("u + f(t) + f(p)", more, f=table).replace("final: 1}\nstates", "final: {lower: 1, upper: 9}}\nstates")
    (phase,) = build(load_text(given, "t.yaml")).phases
    assert phase.final_time == Range(1.0, 2.0)
    assert [(c.name, c.bounds) for c in phase.boundary] == [("v of f", Range(0.0, 2.0))]


def test_outputs_that_no_equation_needs_bound_nothing():
    table = entry([0, 0.5, 1.2], lambda v: 0.1 * v)
    more = f"expressions: {{shown: f(3*v)}}\n{MESH}"
    (phase,) = build(load_text(text("u", more, f=table), "t.yaml")).phases
    assert not phase.path and phase.states[1].bounds == Range()
    assert phase.outputs["shown"].function({"v": np.array([0.1, 0.3])}, np) == pytest.approx([0.03, 0.09])


def test_what_is_held_costs_no_bound():
    table = entry([0, 0.3, 0.6], lambda v: 0.1 + v**2, outside="hold")
    solution = solved(text("u - f(v)", f=table))
    (phase,) = build(load_text(text("u - f(v)", f=table), "t.yaml")).phases
    assert phase.states[1].bounds == Range() and solution["v"](0.5) > 1.2


def test_tables_in_values_that_are_known_before():
    table = entry([0, 1, 2], lambda v: 2 * v)
    given = text("u", f=table).replace("k: 0.5", "k: f(0.25) + 0.5").replace("final: 1}\n  v", "final: f(k/2)}\n  v")
    final = build(load_text(given, "t.yaml")).phases[0].states[0].final
    assert final.fixed and final.lower == pytest.approx(1.0, rel=1e-14)


def test_the_newton_engine_takes_no_bound():
    given = text("u - f(v)", f"solver: {{engine: newton}}\n{MESH}", f=entry([0, 1, 2], lambda v: v))
    with pytest.raises(
        SpecError, match=r"t.yaml:5: tables.f.outside: the Newton engine takes no bounds, and outside: error"
    ):
        load_text(given, "t.yaml")
    assert solved(given.replace("]}, ", "]}, outside: extrapolate, ")).objective > 12


def test_a_table_depends_on_its_arguments_wherever_its_points_are():
    """What `probe` finds out with numbers from 0.1 to 0.9 holds for points far from those, where a table is flat."""
    for way in ("hold", "extrapolate"):
        table = entry([100, 200, 300], lambda v: 0 * v + 7, outside=way)
        more = f"constraints: {{path: [{{expression: 'f(u) + x', upper: 90}}]}}\n{MESH}"
        (phase,) = build(load_text(text("u", more, f=table), "t.yaml")).phases
        assert names_asked(phase.path[0].function) == {"u", "x"} and depends_on(phase.path[0].function, {"u"})


def test_the_aeroplane_has_its_tables_in_its_equations():
    problem = problem_named("min_time_climb")
    (phase,) = problem.phases
    assert set(tables_of(problem)) == {"rho", "sound", "thrust", "CLalpha", "CD0", "eta"}
    assert [c.name for c in phase.path] == ["M of CD0", "h of thrust"]
    thrust = phase.outputs["T"].function({"h": np.array([0.0, 3048.0]), "v": np.array([0.0, 0.0])}, np)
    assert thrust == pytest.approx([24.2 * 4448.222, 20.3 * 4448.222])


def test_formulas_are_exported_with_tables_only_to_be_read(tmp_path):
    path = tmp_path / "t.yaml"
    path.write_text(text("u - f(2*v)", f=entry([0, 1, 2.4], lambda v: 0.1 * v)))
    linked = tmp_path / "linked.yaml"
    link = 'links: [{from: a, to: b}, {expression: "f(a.x[final]) - b.x[initial]", equals: 0}]'
    linked.write_text(
        text(
            "u", f"phases: {{a: {{time: {{final: 0.5}}}}, b: {{}}}}\n{link}\n", f=entry([0, 1, 2.4], lambda v: 0.1 * v)
        )
    )
    for suffix in (".nl", ".gms"):
        for file in (linked, path):
            ran = command_line.trajopt("export", file, tmp_path / f"t{suffix}")
            assert ran.exit_code == 2 and f"the table f cannot be written to {suffix}" in ran.stderr
        assert not (tmp_path / f"t{suffix}").exists()
    assert command_line.trajopt("export", path, tmp_path / "t.tex").exit_code == 0
    assert r"\mathrm{f}" not in (tmp_path / "t.tex").read_text() and "f(2" in (tmp_path / "t.tex").read_text()
