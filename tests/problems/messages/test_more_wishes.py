"""Words of other tools in places where they had got a wrong line, or none; each line, as it is told, works."""

import pytest

from trajopt.problems.errors import SpecError
from trajopt.transcription.loading import load_yaml

FILE = """trajopt: 1
name: w
parameters: {m: 2}
time: {initial: 0, final: 1}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: u/m, initial: 0, final: 0}
controls:
  u: {lower: -10, upper: 10}
objective: {minimize: {integral: u**2}}
"""
RATE, OBJECTIVE, M, U = "rate: u/m", "objective: {minimize: {integral: u**2}}", "m: 2", "upper: 10"

FIRST = "parameters: {m: 2}"

CASES = {  # name: (what the good file has, what was written, what is told, the line as it works)
    "interp with lists": (RATE, 'rate: "interp(x, [0, 1], [1, 2])"', "data stand in a table", None),
    "interp1 with lists": (RATE, 'rate: "u + interp1([0, 1], [1, 2], x)/m"', "data stand in a table", None),
    "a spline with a list of knots": (RATE, 'rate: "spline([0, 1, 2], u)"', "data stand in a table", None),
    "interp without quotes": (RATE, "rate: interp(x, [0, 1], [1, 2])", 'rate: "interp(x, [0, 1], [1, 2])"', None),
    "a vector without quotes": (RATE, "rate: u/m + dot(w, [1, 2])", 'rate: "u/m + dot(w, [1, 2])"', None),
    "hypot without quotes": (RATE, "rate: hypot(u, [1]) - 1", 'rate: "hypot(u, [1]) - 1"', None),
    "a formula as a guess": (U, "upper: 10, guess: sin(t)", "guess: {formulas: {u: sin(t)}} at the left", None),
    "a formula as an initial guess": (U, "upper: 10, init: 2*t", "guess: {formulas: {u: 2*t}}", None),
    "an end of time without an end": ("final: 1}\ns", "final: {lower: 1, upper: inf}}\ns", "write upper: 10, guess: 1",
                                      "final: {lower: 1, upper: 10, guess: 1}}\ns"),
    "no lower end of time": ("final: 1}\ns", "final: {lower: -.inf, upper: 9}}\ns", "write lower: 0.1",
                             "final: {lower: 0.1, upper: 9}}\ns"),
    "tf as the final time": ("final: 1}\ns", "final: tf}\ns", "write final: {lower: 0.1, upper: 10, guess: 1}",
                             "final: {lower: 0.1, upper: 10, guess: 1}}\ns"),
    "T as the final time": ("final: 1}\ns", "final: t_final}\ns", "final: {lower: 0.1, upper: 10, guess: 1}", None),
    "mayer: tf": (OBJECTIVE, "objective: {minimize: {mayer: tf}}", 'write terminal: "t[final]"', None),
    "mayer: x(tf)": (OBJECTIVE, "objective: {minimize: {mayer: m*x(tf) - v(t0)}}",
                     'write terminal: "m*x[final] - v[initial]"', None),
    "mayer at the margin": (OBJECTIVE, "mayer: 2*tf", 'objective: {minimize: {terminal: "2*t[final]"}}', None),
    "minimize time": (OBJECTIVE, "objective: minimize time", 'objective: {minimize: {terminal: "t[final]"}}', None),
    "minimize: final time": (OBJECTIVE, "objective: {minimize: final time}", 'minimize: {terminal: "t[final]"}', None),
    "min u**2": (OBJECTIVE, "objective: min u**2", "objective: {minimize: {integral: u**2}}", None),
    "bolza": (OBJECTIVE, "objective: {bolza: {lagrange: u**2, mayer: tf}}",
              'write minimize: {integral: u**2, terminal: "t[final]"}', None),
    "a thousand with a comma": (U, "upper: 1,000", "write upper: 1000, or 1.000 if it is a point", "upper: 1000"),
    "a negative thousand": (U, "upper: 9, lower: -2,500", "write lower: -2500, or -2.500", None),
    "a thousandth with a comma": (U, "upper: 0,125", "write upper: 0.125", "upper: 0.125"),
    "a thousand in quotes": (U, 'upper: "1,000"', "write upper: 1000, or 1.000 if it is a point", None),
    "a thousand with a space": (U, "upper: 1 000", "write 1000", "upper: 1000"),
    "a thousand with a space in a rate": (RATE, "rate: u/m*2 500", '"2 500" in "u/m*2 500": there is no space', None),
    "an exponent of Fortran as a tolerance": (FIRST, "refine: {tolerance: 1d-6}\n" + FIRST, "write tolerance: 1e-6",
                                              "refine: {tolerance: 1e-6}\n" + FIRST),
    "digits in groups as a number of segments": (FIRST, "mesh: [{method: radau, segments: 1_0}]\n" + FIRST,
                                                 "write segments: 10", None),
    "45 degrees by their sign": (RATE, "rate: u*cos(45°)/m", "write 45*pi/180", "rate: u*cos(45*pi/180)/m"),
    "an angle by its sign": (RATE, "rate: u*sin(x °)/m", "write x*pi/180", None),
    "a fixed end": ("final: 1}\n  v", "final: fixed}\n  v", "write its value, such as final: 1", None),
    "an end that is there": ("final: 0}\ncontrols", "final: yes}\ncontrols", "write its value, such as final: 1", None),
    "an end that is true": ("final: 1}\n  v", "final: true}\n  v", "write its value, such as final: 1", None),
    "a range in parentheses": ("final: 1}\n  v", "final: (0, 1)}\n  v", "write final: {lower: 0, upper: 1}",
                               "final: {lower: 0, upper: 1}}\n  v"),
    "a range without an end, in parentheses": ("final: 1}\n  v", 'final: "(0, inf)"}\n  v', "write final: {lower: 0}",
                                               None),
    "a state as its rate": ("x: {rate: v, initial: 0, final: 1}", "x: v", "write x: {rate: v}", "x: {rate: v}"),
    "one control of several": (RATE, "rate: (u1 + u2)/m", "did you mean u? If not, declare it: under controls: as u2",
                               None),
    "an output without its unit": (FIRST, "outputs: {E: m*v**2}\n" + FIRST,
                                   "write expressions: {E: {value: m*v**2}}",
                                   "expressions: {E: {value: m*v**2}}\n" + FIRST),
    "a range without an end": ("final: 1}\n  v", "final: [0, .inf]}\n  v", "write final: {lower: 0}",
                               "final: {lower: 0}}\n  v"),
    "a range without a beginning": ("final: 1}\n  v", "final: [-inf, 2]}\n  v", "write final: {upper: 2}", None),
    "a range of all": ("final: 1}\n  v", "final: [-.inf, .inf]}\n  v", "leave final: out", None),
    "an end as a comparison": ("final: 1}\n  v", "final: '>= 1'}\n  v", "write final: {lower: 1}",
                               "final: {lower: 1}}\n  v"),
    "an end below": ("final: 1}\n  v", "final: <2.5}\n  v", "write final: {upper: 2.5}", None),
    "max: of the objective": (OBJECTIVE, "objective: {max: u**2}", "write maximize: {integral: u**2}", None),
    "minimise: of the objective": (OBJECTIVE, "objective: {minimise: tf}", 'minimize: {terminal: "t[final]"}', None),
    "digits in groups and an exponent": (M, "m: 1_0e3", "write m: 10e3", "m: 10e3"),
    "digits in groups and a negative one": (M, "m: 1_000e-3", "write m: 1000e-3", "m: 1000e-3"),
    "= before a brace": ("  x: {rate", "  x = {rate", "write x: {rate: v, initial: 0, final: 1}", None),
    "= in a section": ("parameters: {m: 2}", "parameters = {m: 2}", "write parameters: {m: 2}", None),
    "x_dot": ("x: {rate: v, initial: 0, final: 1}", "x_dot: v", "write x: {rate: v}", "x: {rate: v}"),
    "dxdt": ("x: {rate: v, initial: 0, final: 1}", "dxdt: v", "write x: {rate: v}", None),
    "digits in groups and a point": (M, "m: 1_000.5", "write m: 1000.5", "m: 1000.5"),
    "digits in groups in a product": (RATE, "rate: u*1_0.2_5/m", "write 10.25", None),
    "apostrophes": (M, "m: 10'000", "write m: 10000", "m: 10000"),
    "apostrophes, more": (M, "m: 1'000'000.5", "write m: 1000000.5", None),
    "a unit in an expression": (RATE, "rate: u/(2 kg)", "as a: {value: 2, unit: kg}", None),
    "a unit of speed": (RATE, "rate: u*(3 m)", "units do not stand in expressions", None),
    "an angle in degrees": (RATE, "rate: u*sin(x deg)", "write x*pi/180", "rate: u*sin(x*pi/180)"),
    "a sum in degrees": (RATE, "rate: u*sin((x + v) degrees)", "write ...)*pi/180", None),
    "typographic quotes": (RATE, "rate: \u201cu/m\u201d", 'write a plain "', None),
}  # fmt: skip

ADDED = {
    "tables: {rho: {x: [0, 1], y: [1, 2]}}": ["points: [0, 1]", "values: [1, 2]"],
    "tables: {rho: [[0, 1], [1, 2], [2, 4]]}": ["rho: {points: {x: [0, 1, 2]}, values: [1, 2, 4]}"],
    "tables: {rho: {points: {h: [0, 1, 2]}, values: [1, 2, 3], interp: monotone}}": ["kind: monotone"],
    "tables: {rho: {points: {h: [0, 1, 2]}, values: [1, 2, 3], extrapolation: hold}}": ["outside: hold"],
    "table: {rho: {points: {h: [0, 1, 2]}, values: [1, 2, 3]}}": ["tables: in place of table:"],
    "continuation: {parameters.m: 1}": ["write parameters.m: [1]"],
    "outputs: {drag: m*v**2}": ["expressions: {drag: {value: m*v**2}}"],
    "outputs: [m*v]": ["expressions: {power: {value: m*v}}"],
}


def mistakes(text: str) -> list[str]:
    with pytest.raises(SpecError) as error:
        load_yaml(text, (), "w.yaml")
    return [str(mistake) for mistake in error.value.mistakes]


@pytest.mark.parametrize("name", CASES)
def test_the_line_is_told(name):
    old, written, meant, works = CASES[name]
    assert FILE.count(old) == 1
    told = mistakes(FILE.replace(old, written))
    assert any(meant in own for own in told), told
    assert any(f"w.yaml:{FILE[: FILE.index(old)].count(chr(10)) + 1}" in own for own in told), told
    if works:
        load_yaml(FILE.replace(old, works), (), "w.yaml")


@pytest.mark.parametrize("added", ADDED)
def test_what_is_added(added):
    told = mistakes(FILE + added + "\n")
    assert len(told) == len(ADDED[added])
    assert all(own.startswith("w.yaml:11: ") for own in told)
    assert all(meant in own for meant, own in zip(ADDED[added], told, strict=True)), told


@pytest.mark.parametrize(
    ("written", "line"),
    [
        ("rate: u/mm", 0),
        ("rate:\n      u/mm", 1),
        ("rate:\n      u/m +\n      zz", 2),
        ("rate: >\n      u/m +\n      zz", 2),
        ("rate: |\n\n      sgn(u)", 2),
        ("rate: u/m +\n      sgn(v)", 1),
        ("rate: u/m +\n      v", None),
        ("extra:\n      first\n      second\n    rate: u/m", 0),
    ],
)
def test_lines_of_texts_below_their_keys(written, line):
    block = "v:\n    " + written + "\n    initial: 0\n    final: 0"
    text = FILE.replace("v: {rate: u/m, initial: 0, final: 0}", block)
    if line is None:
        load_yaml(text, (), "w.yaml")
        return
    (told,) = mistakes(text)
    assert told.startswith(f"w.yaml:{8 + line}: "), told


@pytest.mark.parametrize(
    ("written", "line"),
    [
        (
            "constraints: {path: {power: {expression: u*v, upper: 3}}}",
            "path: [{name: power, expression: u*v, upper: 3}]",
        ),
        ("constraints: {integral: {e: {expression: u, upper: 3}}}", "integral: [{name: e, expression: u, upper: 3}]"),
        ("mesh: {radau: {segments: 10}}", "mesh: [{method: trapezoid, segments: 20}]"),
    ],
)
def test_a_list_as_a_mapping_of_names(written, line):
    """The line that is told works: the items have their names, or it is an example."""
    (told,) = mistakes(FILE + written + "\n")
    assert line in told
    load_yaml(FILE + (f"constraints: {{{line}}}\n" if "mesh" not in line else line + "\n"), (), "w.yaml")
