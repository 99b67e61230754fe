"""Broken problem files: each a small edit of a good one, with the place and the words its message must have.

`CASES` is data: the tests of the library and of the command line run the same list. `write` puts a case on the disk.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from trajopt.transcription import schemes

METHODS = tuple(schemes.METHODS)

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
  u: {unit: N, lower: -u_max, upper: u_max}
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


@dataclass(frozen=True)
class Case:
    """content: the file, or None for a file that cannot be made by writing bytes (see `write`).

    place: what follows the file name in `where`, such as ":12: states.x.rate", or the whole of it if it starts with
    "--set". says: words that must stand in the sentence. kind: "spec" (exit code 2) or "file" (exit code 3).
    """

    name: str
    content: bytes | None
    place: str
    says: str
    overrides: tuple[str, ...] = ()
    kind: str = "spec"


def write(case: Case, folder: Path) -> Path:
    """The file of a case, in an empty folder."""
    path = folder / "broken.yaml"
    if case.content is not None:
        path.write_bytes(case.content)
    elif case.name == "a folder":
        path.mkdir()
    elif case.name == "a dangling link":
        path.symlink_to(folder / "nowhere.yaml")
    return path


def _edits(text: str):
    """A function that makes cases from a good file."""

    def edit(name: str, old: str, new: str, path: str, says: str, *, line: int | None = None) -> Case:
        """The file with `old` replaced; the mistake stands on the line where `old` begins unless another is given."""
        assert text.count(old) == 1, f"{old!r} must stand once in the good file"
        line = line or text[: text.index(old)].count("\n") + 1
        place = f":{line}: {path}" if path else f":{line}"
        return Case(name, text.replace(old, new).encode(), place, says)

    return edit


_edit = _edits(GOOD)


def _rate(name: str, rate: str, says: str) -> Case:
    """The good file with another rate of v."""
    return _edit(name, "(u - c*v)/m", f"'{rate.replace(chr(39), chr(39) * 2)}'", "states.v.rate", says)


def _set(name: str, override: str, says: str, place: str | None = None) -> Case:
    """The good file with an override."""
    return Case(name, GOOD.encode(), place or f"--set {override.partition('=')[0]}", says, (override,))


def _raw(name: str, content: str | bytes, place: str, says: str) -> Case:
    return Case(name, content if isinstance(content, bytes) else content.encode(), place, says)


_ALIASES = "a: &a [1, 1, 1, 1, 1, 1, 1, 1, 1]\n" + "".join(
    f"{new}: &{new} [{', '.join([f'*{old}'] * 9)}]\n" for old, new in zip("abcdefgh", "bcdefghi", strict=True)
)
_TERMS = '{integral: u**2, terminal: "x[final]*v[final] + c**2"}'
_CHAIN = "".join(f"  e{i}: e{i - 1}*e{i - 1} + e{i - 1}\n" for i in range(1, 60))

FILES = [
    Case("a missing file", None, "", "there is no such file", kind="file"),
    Case("a folder", None, "", "this is a folder", kind="file"),
    Case("a dangling link", None, "", "there is no such file", kind="file"),
    _raw("an empty file", "", "", "the file is empty"),
    _raw("only comments", "# nothing\n\n", "", "the file is empty"),
    _raw("a huge file", "#" * 2_000_000, "", "larger than 1 MB"),
    _raw("binary junk", bytes(range(256)) * 8, ":2", "UTF-8"),
    _raw("binary zeros", b"trajopt: 1\n\x00\x00\x00", ":2", "not a text file"),
    _raw("an HDF5 file", b"\x89HDF\r\n\x1a\n" + bytes(100), ":1", "UTF-8"),
    _raw("Latin-1 text", "trajopt: 1\nname: Brücke\n".encode("latin-1"), ":2", "save the file as UTF-8"),
    _raw("a list", "- 1\n- 2\n", ":1", "not a mapping"),
    _raw("a word", "hello\n", ":1", "not a mapping"),
    _raw("two documents", GOOD + "---\n" + GOOD, ":33", "keep one problem in a file"),
    _raw("a YAML bomb", _ALIASES, ":6", "remove aliases"),
    _raw("a self-reference", "a: &a [*a]\n", ":1", "refers to no anchor"),
    _raw("many aliases", "a: &a 1\nb: [" + "*a, " * 200 + "]\n", ":2", "more than 100 aliases"),
    _raw("deep brackets", "a: " + "[" * 100_000, ":1", "nested deeper"),
    _raw("deep indentation", "".join(" " * i + "a:\n" for i in range(500)), ":22", "nested deeper"),
    _raw("many values", "a: [" + "1," * 400_000 + "]", ":1", "more than 300000 values"),
    _raw("a Python tag", "a: !!python/object/apply:os.system ['true']\n", ":1", "the tag"),
    _raw("a Python tag on a key", "!!python/name:os.system a: 1\n", ":1", "the tag"),
    _raw("a list as a key", "? [1, 2]\n: 3\n", ":1", "a key must be a word"),
    _edit("a tab", "  u_max: 5", "\tu_max: 5", "", "indent with spaces"),
    _edit("a wrong indentation", "  d: 1.0", "   d: 1.0", "", "indent keys of one mapping alike"),
    _edit("an open brace", "unit: kg}", "unit: kg", "", "in what starts on line 4", line=5),
    _edit("an open quote", '"x[final] - x[initial]"', '"x[final] - x[initial]', "", "close the quotes"),
    _edit("brackets without quotes", '"x[final] - x[initial]"', "x[final] - x[initial]", "", "in quotes"),
    _edit("a duplicate key", "  d: 1.0", "  m: 1.0", "parameters.m", "given twice, first on line 4"),
    _edit("a duplicate section", "solver:", "mesh:", "mesh", "first on line 29"),
]

KEYS = [
    _raw("only a version", "trajopt: 1\n", ":1: time", "time is missing"),
    _edit("no version", "trajopt: 1\n", "", "trajopt", "add trajopt: version of the file format: 1"),
    _edit("another version", "trajopt: 1", "trajopt: 2", "trajopt", "write trajopt: 1"),
    _edit("a misspelt section", "controls:", "contols:", "contols", "did you mean controls?"),
    _edit(
        "a section of the future", "solver: {max_iter: 100}", "phases: []", "phases", "the keys here are trajopt, name"
    ),
    _edit("a misspelt key", "rate: v,", "rates: v,", "states.x.rates", "did you mean rate?"),
    _edit("no rate", "rate: v, ", "", "states.x", "rate is missing; add rate: an expression, or residuals:"),
    _edit("no method", "method: hermite-simpson, ", "", "mesh.0.method", "collocation method"),
    _edit("no states", "states:", "controls_: &s\nstates: {}\nunused:", "states", "at least 1", line=12),
    _edit(
        "an empty mesh",
        "  - {method: hermite-simpson, segments: 10, tolerance: 1e-8}",
        "  []",
        "mesh",
        "at least 1",
        line=29,
    ),
    _edit("a mesh that is no list", "  - {method", "  {method", "mesh", 'start each item with "- "', line=29),
    _edit("states as a list", "states:", "states: [x, v]\nother:", "states", "must be a mapping, not a list"),
    _edit("a state as a number", "  x: {unit", "  w: 3\n  x: {unit", "states.w", "must be a mapping, not the number 3"),
    _edit("a bound as a list", "lower: -2", "lower: [-2]", "states.x.lower", "not a list"),
    _edit("a bound as true", "lower: -2", "lower: true", "states.x.lower", "not true"),
    _edit("a name as a list", "name: a good file", "name: [a]", "name", "put the text in quotes"),
    _edit("a long text", "name: a good file", "name: " + "a" * 20_000, "name", "shorten it"),
    _edit(
        "no sense",
        "{minimize: {integral",
        "{least: {integral",
        "objective.least",
        "the keys here are minimize, maximize",
    ),
    _edit("two senses", "objective: {", "objective: {maximize: {integral: v}, ", "objective", "two objectives"),
    _edit("an empty objective", _TERMS, "{}", "objective.minimize", "add integral: or terminal:"),
    _edit("an objective without terms", _TERMS, "u**2", "objective.minimize", "{integral:, terminal:}"),
    _edit("fixed and free", "final: d}", "final: {value: d, lower: 0}}", "states.x.final", "keep the value"),
    _edit("nothing fixed", "final: d}", "final: {}}", "states.x.final", "nothing is given here"),
    _edit("no bound", ", upper: 100", "", "constraints.integral.0", "add lower:, upper: or equals:"),
    _edit("two kinds of bound", "equals: d", "equals: d, lower: 0", "constraints.boundary.0", "keep one"),
    _edit(
        "a kind of guess", "guess:\n  constants: {u: 1}\n  keyframes:", "guess: random\nother:", "guess", "write linear"
    ),
    _edit("a choice", "solver: {", "solver: {accept: good, ", "solver.accept", "'optimal' or 'acceptable'"),
    _edit("an option as a list", "max_iter: 100", "max_iter: [1]", "solver.max_iter", "solver's option"),
    _edit("the option tol", "max_iter: 100", "tol: 1e-6", "solver.tol", "tolerance: in each entry of mesh:"),
]

NUMBERS = [
    _edit("NaN", "u_max: 5", "u_max: .nan", "parameters.u_max", "write a finite number"),
    _edit("infinity", "upper: 2,", "upper: .inf,", "states.x.upper", "leave the key out"),
    _edit("a tolerance of NaN", "tolerance: 1e-8", "tolerance: .nan", "mesh.0.tolerance", "finite number"),
    _edit("a tolerance of zero", "tolerance: 1e-8", "tolerance: 0", "mesh.0.tolerance", "out of range"),
    _edit("a tolerance in words", "tolerance: 1e-8", "tolerance: small", "mesh.0.tolerance", 'not the text "small"'),
    _edit("a million segments", "segments: 10", "segments: 1000000", "mesh.0.segments", "1 to 200000"),
    _edit("no segments", "segments: 10", "segments: 0", "mesh.0.segments", "1 to 200000"),
    _edit("half a segment", "segments: 10", "segments: 10.5", "mesh.0.segments", "whole number"),
    _edit("endless segments", "segments: 10", "segments: .inf", "mesh.0.segments", "whole number"),
    _edit("segments in words", "segments: 10", "segments: many", "mesh.0.segments", "whole number"),
    _edit("a negative width", "segments: 10", "segments: [1, -1]", "mesh.0.segments", "positive relative widths"),
    _edit("an unknown method", "hermite-simpson,", "hermite-simson,", "mesh.0.method", "did you mean hermite-simpson?"),
    _edit("crossed bounds", "lower: -2", "lower: 3", "states.x.lower", "lower 3 is above upper 2"),
    _edit("crossed parameters", "u_max: 5", "u_max: -5", "controls.u.lower", "lower 5 is above upper -5", line=15),
    _edit("crossed statics", "lower: 0.1", "lower: 1", "optimize.c.lower", "above upper 0.5"),
    _edit("crossed limits", "upper: 100", "upper: 1, lower: 2", "constraints.integral.0.lower", "above upper 1"),
    _edit("an end outside the bounds", "final: d}", "final: 3*d}", "states.x.final", "outside the bounds -2 to 2"),
    _edit("a range outside the bounds", "final: d}", "final: {lower: 3}}", "states.x.final", "3 to inf lies outside"),
    _edit("a duration of zero", "final: T}", "final: 0}", "time.final", "make the final time larger"),
    _edit("a negative duration", "T: 2*d", "T: -2*d", "time.final", "the final time -2 is not after", line=10),
    _edit("a free time without a guess", "final: T}", "final: {lower: 1}}", "time.final", "add guess:"),
    _edit("a guess before the start", "final: T}", "final: {lower: -1, guess: -1}}", "time.final", "a larger value"),
    _edit("too few keyframes", "[0, 0.5, 1]", "[0, 1]", "guess.keyframes.x", "the same number of values"),
    _edit("one keyframe", "{time: [0, 1, 2], x: [0, 0.5, 1]}", "{x: [0]}", "guess.keyframes.x", "at least 2"),
    _edit("keyframes that go back", "[0, 1, 2]", "[0, 2, 1]", "guess.keyframes.time", "the times do not increase"),
    _edit("a guess of nothing", "constants: {u: 1}", "constants: {w: 1}", "guess.constants.w", "state or a control"),
    _edit("two guesses", "constants: {u: 1}", "constants: {x: 1}", "guess.constants.x", "keep one of the two"),
    _edit("a constant objective", _TERMS, "{integral: 1}", "objective.minimize", "constant"),
]

NAMES = [
    _edit("a reserved name", "  d: 1.0", "  sin: 1.0\n  d: 1.0", "parameters.sin", "choose another name"),
    _edit("time as a name", "controls:", "  t: {rate: 1}\ncontrols:", "states.t", "choose another name"),
    _edit("a name with a dash", "  d: 1.0", "  d-max: 1.0\n  d: 1.0", "parameters.d-max", "digits and _"),
    _edit("a number as a name", "  d: 1.0", "  1: 1.0\n  d: 1.0", "parameters.1", "use a letter"),
    _edit(
        "a name twice", "controls:\n", "controls:\n  v: {}\n", "controls.v", "already declared under states", line=15
    ),
    _edit(
        "a constraint twice",
        "expression: power",
        "name: speed limit, expression: power",
        "constraints.integral.0.name",
        "its own name",
    ),
    _edit("a name with a slash", "speed limit", "m/s", "constraints.path.0.name", "use letters, digits"),
    _edit("a cyclic parameter", "d: 1.0", "d: T/2", "parameters.", "is a circle"),
    _edit("a parameter of itself", "u_max: 5", "u_max: u_max + 1", "parameters.u_max", "u_max -> u_max is a circle"),
    _edit("a cyclic expression", "power: u*v", "power: u*work\n  work: power*v", "expressions.", "is a circle"),
    _edit(
        "an endless expression",
        "  power: u*v\n",
        "  e0: u\n" + _CHAIN + "  power: e59\n",
        "expressions.e10",
        "refer to fewer expressions",
        line=19,
    ),
    _rate("an unknown name", "(u - c*vv)/m", "did you mean v?"),
    _rate("a name of its own", "(u - k*v)/m", "declare it"),
    _rate("an end in a rate", "u - x[final]", "write x, or move the expression"),
    _edit("a state in a bound", "upper: 2,", "upper: 2*v,", "states.x.upper", "under constraints:"),
    _edit("a state in a parameter", "T: 2*d", "T: 2*x", "parameters.T", "x is a state"),
    _edit(
        "a static as a value", "initial: 0, final: d}", "initial: c, final: d}", "states.x.initial", "static parameter"
    ),
    _edit(
        "a bare state at the boundary",
        '"x[final] - x[initial]"',
        "x",
        "constraints.boundary.0.expression",
        "write x[final] or x[initial]",
    ),
    _edit(
        "bare time in the objective",
        '"x[final]*v[final] + c**2"',
        "t",
        "objective.minimize.terminal",
        "write t[final] or t[initial]",
    ),
    _edit(
        "a bare expression at the boundary",
        '"x[final] - x[initial]"',
        "power",
        "constraints.boundary.0.expression",
        "write power[final] or power[initial]",
    ),
    _edit(
        "an end of a parameter",
        '"x[final] - x[initial]"',
        '"x[final] - d[final]"',
        "constraints.boundary.0.expression",
        "write d",
    ),
]

EXPRESSIONS = [
    _rate("an import", "__import__('os').system('true')", "has no meaning in an expression"),
    _rate("an attribute", "u.real", "no attributes"),
    _rate("a lambda", "(lambda: 1)()", "is a word of Python"),
    _rate("a comprehension", "[v for v in u]", "is a word of Python"),
    _rate("a condition", "u if v else 0", "no branches"),
    _rate("a tower of powers", "9**9**9", "exponent larger than 1000"),
    _rate("a huge power", "u*10**400", "too large a number"),
    _rate("a huge number", "u*1e400", "larger than 1e+100"),
    _rate("a huge exponent", "u**100000", "exponent larger than 1000"),
    _rate("a long expression", "u" + " + u" * 2000, "name its parts under expressions:"),
    _rate("a deep expression", "(" * 200 + "u" + ")" * 200, "nested deeper than 50"),
    _rate("deep powers", "**".join(["u"] * 1200), "nested too deeply"),
    _rate("many signs", "-" * 500 + "u", "write one sign"),
    _rate("an empty expression", " ", "the expression is empty"),
    _rate("a caret", "u^2", "write ** for a power"),
    _rate("a missing operator", "2u", "write 2*u"),
    _rate("a missing parenthesis", "sin(u", "add the missing )"),
    _rate("a parenthesis too many", "u)", ") closes nothing"),
    _rate("a function without parentheses", "sin u", "write sin(u)"),
    _rate("a module", "np.sin(u)", "write sin"),
    _rate("ln", "ln(u)", "write log(u)"),
    _rate("arcsin", "arcsin(u/9)", "write asin(u/9)"),
    _rate("abs", "u - abs(v)", "section 5.5"),
    _rate("max", "max(u, v)", "nonsmooth: {tanh: 0.01}"),
    _rate("an unknown function", "sine(u)", "did you mean sin?"),
    _rate("two arguments", "sin(u, v)", "one argument"),
    _rate("a comparison", "u > 0", "give the bounds as lower:, upper: or equals:"),
    _rate("an index", "u[0]", "write u[initial] or u[final]"),
    _rate("a trailing operator", "u +", "write what stands after it"),
    _rate("a superscript", "u²", "write **2"),
    _rate("a division by zero", "u/(m - 2)", '"u/(m - 2)" divides by zero with m = 2'),
    _rate("a logarithm of zero", "u + log(m - 2)", "is the logarithm of zero with m = 2"),
    _rate("a root of a negative number", "u*sqrt(-m)", '"sqrt(-m)" is not a real number with m = 2'),
    _edit("a parameter without a value", "T: 2*d", "T: 2/(d - 1)", "parameters.T", "divides by zero with d = 1"),
    _edit("a bound without a value", "upper: 2,", "upper: log(d - 1),", "states.x.upper", "change the expression"),
]

OVERRIDES = [
    _set("an override without a value", "parameters.d", "write parameters.u_max=15", "--set parameters.d"),
    _set("an override of nothing", "=3", "this is not PATH=VALUE", "--set =3"),
    _set("a misspelt parameter", "parameters.u_maxx=15", "did you mean u_max?"),
    _set("a misspelt override", "solvr.max_iter=5", "did you mean solver?"),
    _set("an override out of the list", "mesh.3.segments=5", "write an index from 0 to 0"),
    _set("an override by a word", "mesh.first.segments=5", "write an index"),
    _set("an override with a wrong value", "mesh.0.segments=many", "whole number"),
    _set("an override that is not YAML", "parameters.d=[1", "close the bracket"),
    _set("an override with a bomb", "parameters.d=" + "[" * 1000, "nested deeper"),
    _set("an override that crosses bounds", "controls.u.lower=10", "lower 10 is above upper 5"),
    _set("an override of all of nothing", "name.*=3", "nothing for * to mean"),
    _set("an override of an expression", "states.v.rate=2u", "write 2*u"),
    _set("an override with a double dot", "mesh..segments=5", "this is not a path"),
]

IMPLICIT = GOOD.replace("rate: (u - c*v)/m, ", "").replace(
    "optimize:",
    "algebraic:\n  F: {unit: N}\nresiduals:\n  - m*v[rate] - F\n  - {name: force, expression: F - u + c*v}\noptimize:",
)
ACCEL = (
    GOOD.replace("rate: v,", "accel: (u - c*v)/m, velocity: {name: v, unit: m/s, final: 0},")
    .replace("  v: {unit: m/s, rate: (u - c*v)/m, initial: 0, final: 0}\n", "")
)  # fmt: skip
NONSMOOTH = GOOD.replace("integral: u**2", "integral: abs(u*v)").replace("guess:\n", "nonsmooth: slack\nguess:\n")
MODEL = (Path(__file__).parent.parent / "problems" / "biped.yaml").read_text()


_accel, _implicit, _nonsmooth, _model = map(_edits, (ACCEL, IMPLICIT, NONSMOOTH, MODEL))

DYNAMICS = [
    _edit(
        "rate and accel", "rate: v,", "rate: v, accel: u,", "states.x", "keep the rate, or state the dynamics by accel"
    ),
    _edit("rate and velocity", "rate: v,", "rate: v, velocity: {},", "states.x", "rate and velocity are both given"),
    _accel("a misspelt accel", "accel:", "acel:", "states.x.acel", "did you mean accel?"),
    _accel(
        "no accel",
        "accel: (u - c*v)/m, ",
        "",
        "states.x",
        "accel is missing; add accel: an expression, or residuals:",
    ),
    _accel("a velocity of a taken name", "{name: v,", "{name: u,", "states.x.velocity", "already declared"),
    _accel("a velocity of no name", "{name: v,", "{name: 2v,", "states.x.velocity", "use a letter"),
    _accel("crossed bounds of a velocity", "final: 0}", "lower: 1, upper: 0}", "states.x.velocity.lower", "is above"),
    _accel(
        "a velocity out of bounds",
        "final: 0}",
        "upper: 0, final: 1}",
        "states.x.velocity.final",
        "outside the bounds",
    ),
    _accel(
        "a velocity that is a number",
        "{name: v, unit: m/s, final: 0}",
        "3",
        "states.x.velocity",
        "must be a mapping",
    ),
    _accel("an end in an accel", "(u - c*v)/m", "'u - v[final]'", "states.x.accel", "taken at every time"),
    _implicit(
        "too few residuals",
        "  - m*v[rate] - F\n",
        "",
        "residuals",
        "not 1 for 2 algebraic variables (F, v[rate])",
        line=18,
    ),
    _implicit(
        "too many residuals",
        "  - m*v[rate] - F\n",
        "  - F\n  - v[rate]\n",
        "residuals",
        "not 3 for 2",
        line=18,
    ),
    _implicit(
        "an algebraic variable in no residual",
        "m*v[rate] - F\n  - {name: force, expression: F - u + c*v}",
        "m*v[rate] - u\n  - v[rate]",
        "algebraic.F",
        "stands in no residual",
        line=17,
    ),
    _implicit(
        "an implicit state in no residual",
        "m*v[rate] - F",
        "m*v - F",
        "states.v",
        "use v[rate] in residuals:",
        line=13,
    ),
    _implicit(
        "the rate of an explicit state",
        "m*v[rate] - F",
        "m*x[rate] - F",
        "residuals.0",
        "leave out rate: of x",
    ),
    _implicit("the rate of a control", "m*v[rate] - F", "m*u[rate] - F", "residuals.0", "only a state without rate:"),
    _implicit(
        "the acceleration of a state",
        "m*v[rate] - F",
        "v[accel]",
        "residuals.0",
        "write v[initial] or v[final]",
    ),
    _implicit(
        "a rate at the ends",
        "x[final] - x[initial]",
        "v[rate]",
        "constraints.boundary.0",
        "under expressions:",
    ),
    _implicit("a residual without expression", "expression: F - u + c*v", "", "residuals.1", "expression is missing"),
    _implicit("a residual that is a list", "- m*v[rate] - F", "- [1]", "residuals.0", "a number or an expression"),
    _implicit("residuals as a mapping", "residuals:\n", "residuals: {a: 1}\nno:\n", "residuals", "must be a list"),
    _implicit("two residuals of one name", "name: force", "name: speed limit", "residuals.1.name", "its own name"),
    _implicit(
        "a rate of an algebraic variable",
        "{unit: N}\nres",
        "{rate: u}\nres",
        "algebraic.F.rate",
        "unknown key",
    ),
    _implicit(
        "an algebraic name twice",
        "  F: {unit: N}\n",
        "  F: {}\n  d: {}\n",
        "algebraic.d",
        "already declared under parameters",
        line=18,
    ),
    _edit(
        "algebraic without residuals",
        "optimize:",
        "algebraic: {F: {}}\noptimize:",
        "algebraic.F",
        "nothing determines F",
    ),
]

MODELS = [
    _model("an unknown model", "five_link_biped", "five_link_bipped", "model", "did you mean five_link_biped?"),
    _model(
        "a parameter of a model missing",
        "  m5: m1\n",
        "",
        "parameters",
        "needs the parameter m5, mass of the swing tibia",
        line=10,
    ),
    _model("a state that a model has not", "  q5: *angle\n", "  q6: *angle\n", "states.q6", "its states are q1, q2"),
    _model(
        "a control that a model has not",
        "  u5: *motor\n",
        "  w: *motor\n",
        "controls.w",
        "has no w among its controls",
    ),
    _model("a rate beside a model", "q5: *angle", "q5: {rate: dq5}", "states.q5.rate", "remove rate:, or model:"),
    _model(
        "residuals beside a model",
        "objective: {",
        "residuals: [q1]\nobjective: {",
        "residuals",
        "remove residuals:",
    ),
    _model(
        "an output as a name",
        "  u_max: {",
        "  foot_x: 1\n  u_max: {",
        "parameters.foot_x",
        "is an output of the model",
    ),
    _model("an unknown name beside a model", "u5**2", "uu5**2", "objective.minimize.integral", "did you mean u5?"),
    _model("a guess that a model has not", "    dq5: (", "    dq6: (", "guess.constants.dq6", "did you mean dq5?"),
    _edit("a file without states or model", "states:", "states_:", "states_", "did you mean states?"),
]

CONSISTENT = [
    _nonsmooth(
        "a way that is none",
        "nonsmooth: slack",
        "nonsmooth: smooth",
        "nonsmooth",
        "write slack, {tanh: 0.01}",
    ),
    _nonsmooth("tanh without a width", "nonsmooth: slack", "nonsmooth: tanh", "nonsmooth", "{tanh: 0.01}"),
    _nonsmooth("no way", "nonsmooth: slack", "nonsmooth: {}", "nonsmooth", "nothing is given here"),
    _nonsmooth("two ways", "nonsmooth: slack", "nonsmooth: {tanh: 1, sqrt: 1}", "nonsmooth", "keep one of them"),
    _nonsmooth("a misspelt way", "nonsmooth: slack", "nonsmooth: {tahn: 1}", "nonsmooth.tahn", "did you mean tanh?"),
    _nonsmooth(
        "a width of zero",
        "nonsmooth: slack",
        "nonsmooth: {tanh: 0}",
        "nonsmooth.tanh",
        "write a positive number",
    ),
    _nonsmooth("a negative smoothing", "nonsmooth: slack", "nonsmooth: {sqrt: -d}", "nonsmooth.sqrt", "is -1"),
    _nonsmooth("a width that varies", "nonsmooth: slack", "nonsmooth: {sqrt: u}", "nonsmooth.sqrt", "must be known"),
    _nonsmooth(
        "too many widths",
        "nonsmooth: slack",
        "nonsmooth: {tanh: [1, 0.1]}",
        "nonsmooth.tanh",
        "there are 2 values for 1 entry",
    ),
    _nonsmooth("no widths", "nonsmooth: slack", "nonsmooth: {tanh: []}", "nonsmooth.tanh", "at least 1"),
    _nonsmooth("a list of ways", "nonsmooth: slack", "nonsmooth: [slack]", "nonsmooth", "must be a mapping"),
    _nonsmooth("no nonsmooth", "nonsmooth: slack\n", "", "objective.minimize.integral", "section 5.5", line=18),
    _rate("abs of two", "abs(u, v)", "abs takes one argument"),
    _rate("min of one", "min(u)", "2 to 20 arguments"),
    _rate("min of many", "min(" + "u, " * 50 + "v)", "2 to 20 arguments"),
    _rate("a trailing comma", "max(u, )", "a value is missing"),
    _rate("abs and no parentheses", "abs u", "write abs(u)"),
    _rate("abs in an expression of constants", "u*abs(v)*abs(m)", "nonsmooth: slack"),
    _edit(
        "abs at an end",
        '"x[final] - x[initial]"',
        '"abs(x[final])"',
        "constraints.boundary.0.expression",
        "section 5.5",
    ),
    _edit("abs in a named expression", "power: u*v", "power: abs(u*v)", "expressions.power", "section 5.5"),
]

SOLVERS = [
    _edit("another engine", "solver: {", "solver: {engine: snopt, ", "solver.engine", "'ipopt' or 'newton'"),
    _edit("a library", "max_iter: 100", "hsllib: ./evil.so", "solver.hsllib", "--set solver.hsllib=..."),
    _edit("a library in capitals", "max_iter: 100", "HSLlib: ./evil.so", "solver.HSLlib", "data, never code"),
    _edit(
        "a library behind a prefix",
        "max_iter: 100",
        "resto.pardisolib: a.so",
        "solver.resto.pardisolib",
        "load a library",
    ),
    _edit("an option file", "max_iter: 100", "option_file_name: a.opt", "solver.option_file_name", "another file"),
    _edit("an output file", "max_iter: 100", "output_file: a.txt", "solver.output_file", "write a file"),
]

CASES = [*DYNAMICS, *MODELS, *CONSISTENT, *SOLVERS, *FILES, *KEYS, *NUMBERS, *NAMES, *EXPRESSIONS, *OVERRIDES]
