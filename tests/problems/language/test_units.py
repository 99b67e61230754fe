"""`trajopt check` and units: what does not fit is one sentence at its place, and what is unknown is passed over."""

import pytest
from command_line import trajopt

from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.problems.units.check import check_units
from trajopt.problems.units.measure import MAX_LENGTH, alike, measure_of, same
from trajopt.transcription.loading import load_yaml

GOOD = """\
trajopt: 1
parameters:
  m: {value: 2, unit: kg}
  c: {value: 0.1, unit: N*s/m}
  g: {value: 9.81, unit: m/s^2}
  l: {value: 0.5, unit: m}
  span: 2*l
tables:
  drag: {points: {v: [0, 10, 20]}, values: [0, 1, 4], outside: hold, unit: N, units: {v: m/s}}
expressions:
  power: {value: F*v, unit: W}
  load: (F - c*v - drag(v))/m
time: {initial: 0, final: {lower: 0.5, upper: 5, guess: 1}}
states:
  x: {unit: m, rate: v, lower: -5, upper: 2*span, initial: 0, final: span}
  v: {unit: m/s, rate: load, initial: 0, final: 0}
  q: {unit: rad, accel: F*cos(q)/(m*l) - g/l*sin(q), velocity: {name: w, initial: 0, upper: 10}, initial: 0}
controls:
  F: {unit: N, lower: -20, upper: m*g}
objective: {minimize: {integral: power**2/(F*v), terminal: "m*v[final]**2/2 + 9.5*t[final]"}}
constraints:
  path:
    - {expression: v*sqrt(l/g), upper: 3*l}
  boundary:
    - {expression: "x[final] - x[initial]", equals: span}
  integral:
    - {expression: "hypot(v, l*w)", upper: 100*l}
guess:
  keyframes: {x: [0, span], F: [m*g, 0]}
"""
PHASES = """\
trajopt: 1
parameters: {k: {value: 1000, unit: m/km}}
states:
  x: {unit: m, rate: v, initial: 0}
  v: {unit: m/s, rate: u, initial: 0}
controls: {u: {unit: m/s^2, lower: -1, upper: 1}}
time: {initial: 0, final: {lower: 1, upper: 9, guess: 5}}
phases:
  near: {time: {final: {lower: 1, upper: 9, guess: 2}}, constraints: {boundary: [{expression: "x[final]", lower: 1}]}}
  far: {states: {x: {unit: km, rate: v/k, final: 0.004}, v: {final: 0}}}
links:
  - {from: near, to: far, except: [x]}
  - {name: converted, expression: "far.x[initial]*k - near.x[final]", equals: 0}
objective: {minimize: {terminal: "t[final]"}}
"""


def sentences(text, *overrides):
    """What `trajopt check` finds."""
    try:
        load_yaml(text, overrides, "file.yaml", units=True)
    except SpecError as error:
        return [str(mistake) for mistake in error.mistakes]
    return []


@pytest.mark.parametrize("text", [GOOD, PHASES], ids=["one phase", "phases"])
def test_units_that_fit_are_not_spoken_of(text):
    assert sentences(text) == []
    assert not load_yaml(text, (), "file.yaml", units=True).warnings


BROKEN = [
    # (name, what of the good file, what takes its place, line, path, words of the sentence)
    ("a sum", "  load: (", "  odd: x + v\n  load: (", 12, "expressions.odd", '"v" is in m/s, and cannot be added'),
    ("a difference", "(F - c*v -", "(F - c*x -", 12, "expressions.load", '"c*x" is in N*s, and cannot be added'),
    ("a rate", "rate: v,", "rate: F,", 15, "states.x.rate", 'the rate of x is in m/s, and "F" in N; something in'),
    ("an acceleration", "g/l*sin(q)", "g*sin(q)", 17, "states.q.accel", '"g*sin(q)" is in m/s^2, and cannot be added'),
    ("a sine of metres", "cos(q)", "cos(x)", 17, "states.q.accel", 'cos takes a pure number or an angle in rad'),
    ("degrees", "q: {unit: rad", "q: {unit: deg", 17, "states.q.accel", 'and "q" is in deg; multiply'),
    ("a scale", "l: {value: 0.5, unit: m}", "l: {value: 50, unit: cm}", 15, "states.x.upper", "0.01, unit: m/cm"),
    ("a bound", "upper: m*g", "upper: m*l", 19, "controls.F.upper", 'F is in N, and "m*l" in kg*m; something in 1/s^2'),
    ("an end", "final: span}", "final: c}", 15, "states.x.final", 'x is in m, and "c" in N*s/m'),
    ("a velocity", "{name: w,", "{name: w, unit: m/s,", 17, "states.q.velocity", "the rate of q is in rad/s, and"),
    ("a time", "{lower: 0.5,", "{lower: l,", 13, "time.final.lower", 'time is in s, and "l" in m'),
    ("a parameter", "span: 2*l", "span: {value: 2*l, unit: s}", 7, "parameters.span", "span is said to be in s, and"),
    ("an output", "unit: W}", "unit: J}", 11, "expressions.power", 'power is said to be in J, and "F*v" in m*N/s'),
    ("a table", "drag(v)", "drag(x)", 12, "expressions.load", 'v of the table drag is in m/s, and "x" in m'),
    ("a table's value", "unit: N, units", "unit: kg, units", 12, "expressions.load", '"drag(v)" is in kg, and cannot'),
    ("an objective", "m*v[final]**2/2 +", "m*v[final]/2 +", 20, "objective.minimize.terminal", "is added to that of"),
    ("a path constraint", "upper: 3*l", "upper: 3*c", 23, "constraints.path.0.upper", "the expression is in m, and"),
    ("a boundary constraint", "equals: span", "equals: m", 25, "constraints.boundary.0.equals", "and \"m\" in kg"),
    ("an integral", "upper: 100*l", "upper: g", 27, "constraints.integral.0.upper", "the integral is in m, and"),
    ("a guess", "F: [m*g, 0]", "F: [0, m]", 29, "guess.keyframes.F.1", 'F is in N, and "m" in kg'),
    ("a formula of the guess", "guess:\n", "guess:\n  formulas: {v: l*t}\n", 29, "guess.formulas.v", '"l*t" in m*s'),
    ("a simulated guess", ", F: [m*g, 0]}", "}\n  simulate: {F: x}", 30, "guess.simulate.F", 'F is in N, and "x"'),
    ("a varying exponent", "  load: (", "  odd: x**sin(q)\n  load: (", 12, "expressions.odd", "its exponent varies"),
    ("an exponent in metres", "power**2", "power**l", 20, "objective.minimize.integral", "an exponent is a pure"),
    ("a length and a speed", "hypot(v, l*w)", "hypot(x, v)", 27, "constraints.integral.0.expression", 'added to "x"'),
]  # fmt: skip


@pytest.mark.parametrize(("old", "new", "line", "path", "says"), [b[1:] for b in BROKEN], ids=[b[0] for b in BROKEN])
def test_units_that_do_not_fit_are_told_at_their_place(old, new, line, path, says):
    assert GOOD.count(old) == 1
    broken = GOOD.replace(old, new)
    told = sentences(broken)
    assert any(s.startswith(f"file.yaml:{line}: {path}: ") and says in s for s in told), "\n".join(told)
    assert all(len(s) < 400 for s in told)
    assert not sentences(broken, "units=off")
    assert load_yaml(broken, (), "file.yaml")  # as solve reads it


@pytest.mark.parametrize(
    "added",
    [
        "odd: {value: 3 + 5*sin(q), unit: m}", "odd: x + 2*step(x - l, 0.1)", "odd: F - 4*(x/l)", "odd: x + sin(t)",
        "ahead(T): 3 + 5*step(T, 1)\n  odd: x - ahead(t)",
    ],
)  # fmt: skip
def test_a_number_times_a_pure_number_is_a_number(added):
    told = sentences(GOOD.replace("  load: (", f"  {added}\n  load: ("))
    assert not [own for own in told if "5*" in own or "2*" in own or "4*" in own or "ahead" in own]
    assert bool(told) == added.endswith("sin(t)")  # which has no number, and is no length


@pytest.mark.parametrize("added", ["odd: x + sin(q)", "odd: x + 2*q", "odd: v + 5*x*sin(q)", "odd: sin(q)*x - 3*v"])
def test_a_number_times_what_has_a_unit_is_none(added):
    assert any(": expressions.odd: " in own for own in sentences(GOOD.replace("  load: (", f"  {added}\n  load: (")))


PHASES_BROKEN = [
    ("a link", "far.x[initial]*k -", "far.x[initial] -", "links.1.expression", "multiply it by a parameter"),
    ("what goes on", ", except: [x]}", "}", "links.0", "x goes on from near, in m, to far, in km"),
    ("a rate of a phase", "rate: v/k", "rate: v", "phases.far.states.x.rate", "the rate of x is in km/s"),
    ("a constraint of a phase", ", lower: 1}]", ", lower: k}]", "phases.near.constraints.boundary.0.lower", '"k"'),
    ("an objective of all", '"t[final]"', '"t[final] + near.x[final]"', "objective.minimize.terminal", '"near.x'),
]  # fmt: skip


@pytest.mark.parametrize(
    ("old", "new", "path", "says"), [b[1:] for b in PHASES_BROKEN], ids=[b[0] for b in PHASES_BROKEN]
)
def test_units_of_phases_and_between_them(old, new, path, says):
    assert PHASES.count(old) == 1
    line = PHASES[: PHASES.index(old)].count("\n") + 1
    told = sentences(PHASES.replace(old, new))
    assert any(s.startswith(f"file.yaml:{line}: {path}: ") and says in s for s in told), "\n".join(told)


@pytest.mark.parametrize(
    "expression",
    ["x + 3", "9.81*m + F", "x/1000 + 0.001*v", "sin(2*t)*l + x", "tanh((7.5 - x)/10)*l + x",
     "x + unknown", "unknown*v + F", "sin(unknown) + x", "(t - 1)/2 + x", "4/3*pi*l**3/l**2 + x",
     "max(x, 3)", "(x**2)**(1/2) + l"],
)  # fmt: skip
def test_what_may_be_right_is_passed_over(expression):
    text = GOOD.replace("  load: (", f'  odd: "{expression}"\n  load: (').replace("  span:", "  unknown: 3\n  span:")
    assert not sentences(text + "nonsmooth: slack\n")


def test_a_file_without_units_is_passed_over_and_so_is_its_time():
    text = "\n".join(line.replace("unit: ", "note: ") for line in GOOD.splitlines()).replace(", units: {v: m/s}", "")
    assert not sentences(text.replace("load\n", "load\n  odd: tanh(t) + x + exp(v)\n"))


def test_a_unit_that_is_none_is_a_warning():
    text = GOOD.replace("unit: kg}", "unit: cells/ml}").replace("unit: W}", "unit: m/s2}")
    warnings = load_yaml(text, (), "file.yaml", units=True).warnings
    assert [w.where for w in warnings] == ["file.yaml:3: parameters.m.unit", "file.yaml:11: expressions.power.unit"]
    assert '"m/s2" is no unit that can be checked' in warnings[1].what


def test_all_mistakes_at_once():
    told = sentences(GOOD.replace("rate: v,", "rate: F,").replace("upper: m*g", "upper: nobody"))
    assert len(told) == 2 and "the rate of x" in told[0] and "nobody" in told[1]


@pytest.mark.parametrize(
    "text",
    ["9**9**9", "m**(9**9**9)", "m^999999", "1e999 m", "(((", "m; import os", "0 m", "m" * (MAX_LENGTH + 1), "m/"],
)
def test_a_strange_text_is_no_unit(text):
    assert measure_of(text) is None


def test_units_are_compared_with_their_scales():
    assert same(measure_of("slug*ft/s^2"), measure_of("lbf")) and same(measure_of("N*m/rad"), measure_of("Nm"))
    assert same(measure_of("kg/(mg*day)").times(measure_of("mg/kg")), measure_of("1/day"))
    assert alike(measure_of("km"), measure_of("m")) and not same(measure_of("km"), measure_of("m"))
    assert not alike(measure_of("m"), measure_of("s")) and measure_of("deg").pure and measure_of("degC/s").scale == 1
    assert str(measure_of("m").over(measure_of("N*s^2"))) == "1/kg" and str(measure_of("-")) == "a pure number"


def test_the_command_line_tells_it_and_solve_does_not_ask(tmp_path):
    path = tmp_path / "block.yaml"
    path.write_text(
        "trajopt: 1\ntime: {initial: 0, final: 1}\nstates:\n  x: {unit: m, rate: v, initial: 0, final: 1}\n"
        "  v: {unit: m/s, rate: u, initial: 0, final: 0}\ncontrols: {u: {unit: N}}\n"
        "objective: {minimize: {integral: u**2}}\nmesh: [{method: hermite-simpson, segments: 5}]\n"
    )
    told = trajopt("check", path)
    assert told.exit_code == 2 and "block.yaml:5: states.v.rate: the rate of v is in m/s^2" in told.stderr
    assert trajopt("check", path, "--set", "units=off").exit_code == 0
    assert trajopt("solve", path, "-q", "-o", tmp_path / "block.h5").exit_code == 0


MEASURED = """\
trajopt: 1
parameters: {k: {value: 1, unit: 1/h}}
time: {initial: 0, final: 1, unit: h}
states:
  y: {unit: mol, rate: -a*y, initial: 1}
  q: {unit: m, rate: a*q, initial: 1}
optimize: {a: {unit: 1/h, lower: 0, upper: 5, guess: 1}}
measurements:
  run:
    data: {time: [0, 0.5, 1], y: [1, 0.8, 0.6], late: [1, 2, 3], s: [0.1, 0.1, 0.2]}
    compare: {y: y, late: 2*q}
    units: {time: h, y: mol, late: m, s: mol}
    deviations: {y: s, late: 0.1}
"""


def test_columns_of_measurements_have_units():
    assert sentences(MEASURED) == []
    for given, told in (
        ("time: h,", "the column time is in h, and the time of the problem is"),
        ("y: mol,", "units.y: the column y is in kg, and what it is compared with is in mol"),
        ("late: m,", "units.late: the column late is in kg, and what it is compared with is in m"),
        ("s: mol}", "units.s: the column s is in kg, and y, whose deviation it is, is in mol"),
    ):
        key = given.partition(":")[0]
        text = MEASURED.replace(f" {given}" if given[0] != "t" else given, f" {key}: kg{given[-1]}")
        assert text != MEASURED
        assert any("measurements.run." in line for line in sentences(text)), sentences(text)
        assert any(told.replace("in h", "in kg") in line for line in sentences(text)), sentences(text)


def test_squares_of_different_units_are_not_added():
    text = MEASURED.replace("    deviations: {y: s, late: 0.1}\n", "")
    (told,) = sentences(text)
    assert told.startswith(
        "file.yaml:9: measurements.run: y is in mol, and late in m: their squares are added; give dev"
    )
    assert sentences(text.replace("late: 2*q}", "late: k*y/a}").replace("late: m,", "late: mol,")) == []
    penalty = "objective: {minimize: {terminal: a*y[final]}}\n"
    assert any(
        "mol^2" in line or "pure" in line
        for line in sentences(MEASURED + penalty.replace("a*y[final]", '"a*y[final]"'))
    )


CONTACT = """\
trajopt: 1
parameters: {m: {value: 1, unit: kg}, r: {value: 0.1, unit: m}}
time: {initial: 0, final: 1}
states:
  y: {unit: m, rate: v, initial: 1}
  v: {unit: m/s, rate: f/m, initial: 0}
controls: {f: {unit: N, lower: 0, upper: 9}}
complementarity: [{name: ground, a: y - r, b: f}, {a: r + y*v/v, b: f*v}]
objective: {minimize: {integral: f**2}}
"""


def test_pairs_have_units():
    assert sentences(CONTACT) == []
    for old, new, place in (
        ("a: y - r", "a: y - m", "complementarity.0.a"),
        ("b: f*v", "b: f*v + m", "complementarity.1.b"),
        ("b: f}, {", "b: f + y}, {", "complementarity.0.b"),
    ):
        (told,) = sentences(CONTACT.replace(old, new))
        assert told.startswith(f"file.yaml:8: {place}: ")


@pytest.mark.parametrize(
    ("body", "call", "says"),
    [
        ("k*w + m", "drag(x)", '"drag(x)" adds what is in kg to what is in N'),
        ("w - m/k", "drag(x*k)", '"drag(x*k)" adds what is'),
        ("hypot(k*w, m)", "drag(x)", '"drag(x)" adds what is in kg to what is in N'),
    ],
)
def test_what_a_function_adds_is_told_of_its_call(body, call, says):
    text = f"""\
trajopt: 1
parameters: {{m: {{value: 2, unit: kg}}, k: {{value: 3, unit: N/m}}}}
expressions: {{drag(w): "{body}"}}
time: {{initial: 0, final: 1}}
states: {{x: {{unit: m, rate: v}}, v: {{unit: m/s, rate: "(u - {call})/m"}}}}
controls: {{u: {{unit: N}}}}
objective: {{minimize: {{integral: u**2}}}}
"""
    with pytest.raises(SpecError) as error:
        load_text(text, "x.yaml", more=check_units)
    assert any(str(own).startswith(f"x.yaml:5: states.v.rate: {says}") for own in error.value.mistakes), error.value


RIDE = """\
trajopt: 1
parameters:
  rho: {value: 1.2, unit: kg/m^3}
  A: {value: 0.5, unit: m^2}
  m: {value: 80, unit: kg}
expressions:
  drag(w): {value: 0.453*rho*A*w**2, unit: N}
  power(w): {value: drag(w)*w, unit: W}
time: {initial: 0, final: 10}
states:
  x: {unit: m, rate: v, initial: 0}
  v: {unit: m/s, rate: (F - drag(v))/m, initial: 0}
controls: {F: {unit: N, upper: 400}}
constraints: {path: [{expression: power(v) + power(2*v), upper: 8000}]}
objective: {maximize: {terminal: "x[final]"}}
"""
OF_PHASES = """phases: {a: {time: {final: 5}}, b: {}}
links: [{name: pull, expression: "m*b.v[initial] + pull(b.x[initial])", lower: 0}]
"""
PULL = "  pull(w): {value: 2.7*w, unit: UNIT}\ntime:"


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [
        ("0.453*", "", []),
        ("0.453*", "0.5*m*", ['7: expressions.drag(w): drag(w) is said to be in N, and "drag(v)" is in']),
        ("unit: W", "unit: N", ['8: expressions.power(w): power(w) is said to be in N, and "power(v)" is in m*N/s']),
        (
            "unit: N}\n  power",
            "unit: J}\n  power",
            ['12: states.v.rate: "drag(v)" is in J, and cannot be added'],
        ),
        ("drag(v))/m", "m*drag(v))/m", ['12: states.v.rate: "m*drag(v)" is in kg*N, and cannot be added']),
        ("power(2*v)", "power(2*x)", ['8: expressions.power(w): power(w) is said to be in W, and "power(2*x)" is in']),
        ("drag(w)*w", "2*drag(w)", ['8: expressions.power(w): power(w) is said to be in W, and "2*drag(w)" in N']),
    ],
)
def test_the_unit_of_a_function_is_compared_with_what_follows_from_its_calls(old, new, says):
    assert sentences(RIDE) == []
    told = sentences(RIDE.replace(old, new))
    assert [own for own in says if not any(f"file.yaml:{own}" in line for line in told)] == []
    assert bool(told) == bool(says)


def test_the_unit_of_a_function_counts_in_links():
    text = RIDE.replace("time:", PULL) + OF_PHASES
    assert sentences(text.replace("UNIT", "kg*m/s")) == []
    (told,) = sentences(text.replace("UNIT", "N"))
    assert '"pull(b.x[initial])" is in N, and cannot be added to "m*b.v[initial]", which is in kg*m/s' in told
    (told,) = sentences(text.replace("2.7*w", "m*w").replace("UNIT", "kg*m/s"))
    assert "9: expressions.pull(w): pull(w) is said to be in kg*m/s, and" in told


@pytest.mark.parametrize("power", [40, 120, 900])
def test_large_powers_of_units_are_told(power):
    """Pint's factors overflow at some power; the sentence needs none of them."""
    text = GOOD.replace("l: {value: 0.5, unit: m}", "l: {value: 0.5, unit: in}")
    told = sentences(text.replace("upper: m*g", f"upper: m*g + l**{power}"))
    assert any(f"l**{power}" in own and f"in^{power}" in own for own in told)
