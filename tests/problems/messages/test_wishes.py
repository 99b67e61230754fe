"""Words of other tools and slips: each message gives the line as it should be written, and that line works."""

import pytest

from trajopt.problems.errors import SpecError
from trajopt.transcription.loading import load_yaml

FILE = """trajopt: 1
name: w
parameters:
  m: 2.0
  c: 0.1
time: {initial: 0, final: 1}
states:
  x: {unit: m, rate: v, initial: 0, final: 1}
  v:
    unit: m/s
    rate: u/m - c*v
    initial: 0
controls:
  u: {unit: N, lower: -50, upper: 50}
objective:
  minimize:
    integral: u**2
mesh:
  - {method: hermite-simpson, segments: 10}
"""

RATE, TERM, ROW = "u/m - c*v", "integral: u**2", "{method: hermite-simpson, segments: 10}"
FREE = "{lower: 0.1, upper: 10, guess: 1}"

WISHES = {  # name: (what the good file has, what was written in its place, the line that the message gives)
    "lagrange": (TERM, "lagrange: u**2", "integral: u**2"),
    "running cost": (TERM, "running_cost: u**2 + v**2", "integral: u**2 + v**2"),
    "mayer": (TERM, "mayer: c*v[final]**2", 'terminal: "c*v[final]**2"'),
    "lagrange below the objective": ("minimize:\n    integral: u**2", "lagrange: u**2", "minimize: {integral: u**2}"),
    "an objective in short": ("minimize:\n    integral: u**2", "minimize: u**2", "minimize: {integral: u**2}"),
    "an end in short": ("minimize:\n    integral: u**2", 'minimize: "v[final]"', 'minimize: {terminal: "v[final]"}'),
    "tf": (TERM, "terminal: v[final]*tf", "t[final]"),
    "t0": (TERM, "terminal: v[final]*(t_f - t0)", "t[initial]"),
    "x(tf)": (TERM, "terminal: v(tf)", "v[final]"),
    "x(1)": (TERM, "terminal: v(1)", "v[final]"),
    "x[end]": (TERM, "terminal: v[end]", "v[final]"),
    "x[0]": (TERM, "terminal: u[0]", "u[initial]"),
    "x_f": (TERM, "terminal: v_f", "v[final]"),
    "x_0": (TERM, "terminal: u0", "u[initial]"),
    "x.final": (TERM, "terminal: u.final", "u[final]"),
    "final(x)": (TERM, "terminal: final(u)", "u[final]"),
    "sign": (RATE, "u/m - c*sign(v)", "sign(v, eps)"),
    "sind": (RATE, "u/m - c*sind(v)", "sin(pi/180*(v))"),
    "atan2d": (RATE, "u/m - c*atan2d(v, 1)", "180/pi*atan2(v, 1)"),
    "deg2rad": (RATE, "u/m - c*sin(deg2rad(v))", "pi/180*(v)"),
    "degrees in a function": (RATE, "u/m - sin(30 deg)*v", "30*pi/180"),
    "interp": (RATE, "u/m - interp1(v)", "rho: {points: {h: [0, 1e4, 2e4]}"),
    "an exponent of Fortran": (RATE, "u/m - 1.5d-1*v", "1.5e-1"),
    "digits in groups": ("m: 2.0", "m: 10_000", "10000"),
    "an exponent of a number": ("m: 2.0", "m: 1d-1", "1e-1"),
    "a number with a comma": ("m: 2.0", "m: 1,5", "m: 1.5"),
    "a number with a unit": ("c: 0.1", "c: 0.1 N*s/m", "c: {value: 0.1, unit: N*s/m}"),
    "a mass with a unit": ("m: 2.0", "m: 2.0 kg", "m: {value: 2.0, unit: kg}"),
    "a percentage": ("c: 0.1", "c: 5%", "c: 0.05"),
    "an angle in degrees": ("c: 0.1", "c: 30 deg", "c: 30*pi/180"),
    "a rate with its left side": (RATE, "v_dot = u/m", "rate: u/m"),
    "dxdt": ("rate: v,", "dxdt: v,", "rate: v"),
    "min and max": ("lower: -50, upper: 50", "min: -50, upper: 50", "lower: -50"),
    "bounds": ("lower: -50, upper: 50", "bounds: [-50, 50]", "lower: -50, upper: 50"),
    "start": ("initial: 0, final: 1}\n  v", "start: 0, final: 1}\n  v", "initial: 0"),
    "a range in brackets": ("final: 1}\n  v", "final: [0, 1]}\n  v", "final: {lower: 0, upper: 1}"),
    "a free final time": ("{initial: 0, final: 1}\n", "{initial: 0, final: free}\n", f"final: {FREE}"),
    "a free time as null": ("{initial: 0, final: 1}\n", "{initial: 0, final: none}\n", f"final: {FREE}"),
    "time in brackets": ("time: {initial: 0, final: 1}", "time: [0, 1]", "time: {initial: 0, final: 1}"),
    "time as a number": ("time: {initial: 0, final: 1}", "time: 1", "time: {initial: 0, final: 1}"),
    "tf at the margin": ("time: {initial: 0, final: 1}", "tf: 1", "time: {initial: 0, final: 1}"),
    "controls in a list": (
        "controls:\n  u: {unit: N, lower: -50, upper: 50}",
        "controls: [u]",
        "controls: {u: {}}",
    ),
    "a mesh in short": ("mesh:\n  - " + ROW, "mesh: " + ROW, f"mesh: [{ROW}]"),
    "nodes": ("segments: 10", "nodes: 10", "segments: 10"),
    "rk4": ("method: hermite-simpson", "method: rk4", "runge-kutta-4"),
    "LGR": ("method: hermite-simpson", "method: LGR", "radau"),
    "a comma in braces": ("rate: v,", "rate: v + 0*hypot(v, 1),", 'rate: "v + 0*hypot(v, 1)"'),
    "commas in braces": ("rate: v,", "rate: norm(v, 1, 2) - norm(1, 2),", 'rate: "norm(v, 1, 2) - norm(1, 2)"'),
    "a bracket in braces": (
        "minimize:\n    integral: u**2",
        "minimize: {terminal: v[final]**2}",
        'terminal: "v[final]**2"',
    ),
    "a colon without a space": ("{initial: 0, final: 1}\n", "{initial:0, final: 1}\n", "initial: 0"),
    "an entry with =": ("  c: 0.1", "  c = 0.1", "c: 0.1"),
    "a rate as an equation": (
        "  x: {unit: m, rate: v, initial: 0, final: 1}",
        "  x_dot = v",
        "x: {rate: v}",
    ),
}  # fmt: skip

ADDED = {  # what is added to the good file, and the line that the message gives
    "outputs: {power: u*v}": "expressions: {power: {value: u*v}}",
    "method: trapezoid": "mesh: [{method: trapezoid, segments: 20}]",
    "tolerance: 1e-6": "refine: {tolerance: 1e-6}",
    "guess: {x: 1}": "constants: {x: 1}",
    "guess: {x: [0, 1]}": "keyframes: {x: [0, 1]}",
    "guess: old.h5": "trajopt solve FILE --guess old.h5",
    "guess: {file: old.h5}": "trajopt solve FILE --guess old.h5",
    "guess: old.csv": "guess: {file: old.csv}",
    "guess: {v: 2*t}": "formulas: {v: 2*t}",
    "constraints: [1 >= x]": "constraints: {path: [{expression: x, upper: 1}]}",
    "constraints: {path: [x <= u <= 2*x]}": "{expression: u, lower: x, upper: 2*x}",
    "constraints: {path: [{name: n, expression: x[1]*2, upper: 1}]}": 'put it in quotes: expression: "x[1]*2"',
    "constraints: {periodic: [v]}": 'boundary: [{expression: "v[final] - v[initial]", equals: 0}]',
    "interp: {rho: [1, 2]}": "tables: {rho: {points: {h: [0, 1e4, 2e4]}, values: [1.2, 0.4, 0.09]}}",
    "include: other.yaml": "x: &shared {unit: m}",
    "options: {max_iter: 5}": "solver: in place of options:",
    "dynamics: {x: v, v: u}": "states: {x: {rate: v}, v: {rate: u}}",
    "subject_to: {path: []}": "constraints: in place of subject_to:",
}


def mistakes(text: str) -> list[str]:
    with pytest.raises(SpecError) as error:
        load_yaml(text, (), "w.yaml")
    return [str(mistake) for mistake in error.value.mistakes]


def line_of(old: str) -> int:
    return FILE[: FILE.index(old)].count("\n") + 1


@pytest.mark.parametrize("name", WISHES)
def test_the_line_as_it_should_be_written(name):
    old, written, meant = WISHES[name]
    assert FILE.count(old) == 1
    told = mistakes(FILE.replace(old, written))
    assert any(f"w.yaml:{line_of(old)}" in own or "\n" in old for own in told), told
    assert any(meant in own.partition("; ")[2] for own in told), told


WRITTEN = {  # the place of the good file, and the line of a message, as a user would then write it
    "mayer": (TERM, 'terminal: "c*v[final]**2"'),
    "an end in short": ("minimize:\n    integral: u**2", 'minimize: {terminal: "v[final]"}'),
    "tf": (TERM, "terminal: v[final]*t[final]"),
    "x(tf)": (TERM, "terminal: v[final]"),
    "x_0": (TERM, "terminal: u[initial]"),
    "sign": (RATE, "u/m - c*sign(v, 0.1)"),
    "sind": (RATE, "u/m - c*sin(pi/180*(v))"),
    "atan2d": (RATE, "u/m - c*180/pi*atan2(v, 1)"),
    "an exponent of Fortran": (RATE, "u/m - 1.5e-1*v"),
    "a number with a unit": ("c: 0.1", "c: {value: 0.1, unit: N*s/m}"),
    "an angle in degrees": ("c: 0.1", "c: 30*pi/180"),
    "a range in brackets": ("final: 1}\n  v", "final: {lower: 0, upper: 1}}\n  v"),
    "a free final time": ("final: 1}\n", f"final: {FREE}}}\n"),
    "controls in a list": ("controls:\n  u: {unit: N, lower: -50, upper: 50}", "controls: {u: {}}"),
    "a mesh in short": ("mesh:\n  - " + ROW, f"mesh: [{ROW}]"),
    "commas in braces": ("rate: v,", 'rate: "norm(v, 1, 2) - norm(1, 2)",'),
}


@pytest.mark.parametrize("name", WRITTEN)
def test_the_line_works(name):
    old, line = WRITTEN[name]
    assert WISHES[name][2] in line or name == "sign"
    load_yaml(FILE.replace(old, line, 1), (), "w.yaml")


@pytest.mark.parametrize("added", ADDED)
def test_what_is_added(added):
    (told,) = mistakes(FILE + added + "\n")
    assert told.startswith("w.yaml:20: "), told
    assert ADDED[added] in told, told


def test_what_a_key_means_is_not_missing_too():
    """One mistake, one sentence."""
    for old, new in [
        ("time: {initial: 0, final: 1}", "time: {t0: 0, final: 1}"),
        ("time:", "duration:"),
        ("objective:", "cost:"),
        ("rate: v,", "dot: v,"),
        ("rate: v, initial: 0", "rate: v, initial:0"),
    ]:
        assert len(mistakes(FILE.replace(old, new))) == 1, new


@pytest.mark.parametrize(("old", "words"), [("upper: 50", "upper: inf"), ("upper: 50", "upper: .inf")])
def test_no_bound_is_no_key(old, words):
    (told,) = mistakes(FILE.replace(old, words))
    assert told.startswith("w.yaml:14: controls.u.upper: ") and told.endswith("leave upper: out for no bound")


def test_a_free_end_is_no_key():
    for word in ("free", "none", "no", "false"):
        (told,) = mistakes(FILE.replace("    initial: 0", f"    initial: {word}"))
        assert "leave initial: out" in told


def test_a_control_that_is_not_declared():
    told = mistakes(FILE.replace(RATE, "F/m - c*v"))
    assert "declare it: under controls: as F: {} if it is to be found" in told[0]


def test_a_space_that_is_none_is_named():
    for bad in ("\u00a0 c: 0.1", "  c:\u202f0.1,\n", "\u2003\u2003c: 0.1"):
        told = mistakes(FILE.replace("  c: 0.1", bad))
        assert told[0].startswith("w.yaml:5") and "U+" in told[0] and "space" in told[0], told
    assert "U+200B, zero width space" in mistakes(FILE.replace(RATE, "u/m -\u200b c*v"))[0]


def test_a_guess_of_a_control_names_the_control():
    (told,) = mistakes(FILE.replace("upper: 50", "upper: 50, guess: 3"))
    assert told.endswith("write guess: {constants: {u: 3}} at the left margin")
    (told,) = mistakes(FILE.replace("unit: m/s", "unit: m/s\n    guess: [0, 2, 0]"))
    assert told.endswith("write guess: {keyframes: {v: [0, 2, 0]}} at the left margin")


@pytest.mark.parametrize(
    ("rate", "line"),
    [
        (">-\n      u/m\n      - cc*v", 13),
        ("|\n      u/m\n      - c*v\n      + w", 14),
        ("\n      uu/m - c*v", 12),
        (">-\n\n      u/m\n      - c*sin(v, v)", 14),
    ],
)
def test_a_mistake_in_a_text_of_several_lines_has_its_own_line(rate, line):
    (told,) = mistakes(FILE.replace(f"rate: {RATE}", f"rate: {rate}"))
    assert told.startswith(f"w.yaml:{line}: states.v.rate: "), told


def test_a_brace_that_stays_open_has_its_own_line():
    (told,) = mistakes(FILE.replace("initial: 0, final: 1}\n  v:", "initial: 0, final: 1\n  v:"))
    assert told.startswith("w.yaml:8: ") and told.endswith("final: 1}")


def test_an_entry_without_a_colon_has_its_own_line():
    (told,) = mistakes(FILE.replace("    initial: 0\n", "    initial 0\n"))
    assert told.startswith("w.yaml:12: this is not YAML (an entry without a colon)")
