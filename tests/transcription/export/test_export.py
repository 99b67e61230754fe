"""Exported programs, read back by readers of their own (`exported`): the numbers are those of the compiled program."""

import re
import time
from dataclasses import replace
from math import inf
from pathlib import Path

import numpy as np
import pytest
from command_line import trajopt
from matplotlib.mathtext import MathTextParser
from named import crossed, share
from repository import ROOT

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.transcription.export.export import export
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import steps
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, transcribe

from .exported import Program, formulas, read_gms, read_nl, read_tex

SHIPPED = sorted((ROOT / "problems").glob("*.yaml"))
FILES = [path for path in SHIPPED if "\ntables:" not in path.read_text()]  # formulas have none, see tables_files
READERS = {".nl": read_nl, ".gms": read_gms, ".tex": read_tex}
FORMAT = pytest.mark.parametrize("suffix", READERS)

MANY = r"""
trajopt: 1
name: '100% of {all} there_is: \, ~ ^ & # $ < > Ångström, θ'
parameters: {tiny: 1.0e-7}
time: {initial: {lower: -1, upper: 0.5, guess: 0}, final: {lower: 1, upper: 3, guess: 2}}
states:
  a: {rate: -a + force/(1 + t**2/(2 + sin(force)**2)), initial: 1, lower: -5}
  long_name: {rate: v, initial: 0, upper: 4}
  v: {initial: {lower: 0, upper: 1}}
algebraic:
  r: {}
residuals:
  - 2*v[rate] - r
  - {name: rör - force_2, expression: r - force*cos(a)*exp(-v)*tanh(long_name)}
controls:
  force: {lower: -1, upper: 1}
  free: {}
optimize:
  p: {lower: 0.5, upper: 2, guess: 1}
  q1: {guess: 0.2}
objective: {maximize: {integral: "-force**2 - tiny*v*(-a)*(a - (v - 2))/(-(force + p)**-2)", terminal: "-a[final]**2"}}
constraints:
  path:
    - {name: low, expression: "sqrt(1 + v**2)*-3", lower: -20}
    - {name: high_1, expression: "log(2 + a**2)/p/(1 + free**2) - (q1 - free)", upper: 30}
    - {name: both, expression: "asin(a/9) + acos(a/9) - atan(v)*sinh(a/9)*cosh(v)/tan(1 + v/9)", lower: -9, upper: 9}
    - {name: same, expression: "free - (a - (-v))**3/5**(a/9)", equals: 1}
  boundary: [{name: end, expression: "v[final]*a[initial]", lower: -1}]
  integral: [{name: effort, expression: "(force - v)**2", upper: 10}]
mesh: [{method: hermite-simpson, segments: 3}]
"""


class Reference:
    """The program as it is compiled for IPOPT, at a random point within its bounds and near its guess."""

    def __init__(self, problem, mesh: Mesh):
        self.problem, self.meshes = problem, [mesh] * len(problem.phases)
        self.transcription = transcribe(problem, self.meshes)
        self.variables = self.transcription.variables
        self.bounds = [(-inf if v.lb is None else v.lb, inf if v.ub is None else v.ub) for v in self.variables]
        away = np.random.default_rng(0).uniform(-0.1, 0.1, len(self.variables))
        self.z = np.clip([v.value for v in self.variables] + away, *np.transpose(self.bounds))

    def names(self, suffix: str) -> list[str]:
        names = [v.name for v in self.variables]
        return [tex_name(name, len(self.meshes) > 1) for name in names] if suffix == ".tex" else names

    def values(self, suffix: str) -> dict[str, float]:
        values = dict(zip(self.names(suffix), self.z.tolist(), strict=True))
        if suffix == ".tex":  # it names the times even where they are fixed
            varying = [phase.name for phase in self.problem.phases if not phase.static]
            blocks = [self.transcription.model.phase[name] for name in varying]
            times = [t for block in blocks for t in (block.t0, block.tF)]
            values |= {tex_name(t.name, len(self.meshes) > 1): t.value for t in times if t.fixed}
        return values

    def program(self, suffix: str) -> Program:
        nlp = compiled(self.transcription)
        g = nlp.constraints(self.z)
        rows = np.concatenate([family.rows(nlp) for family in self.transcription.families])
        names = [label(*nlp.row_name(row), suffix) for row in rows]
        slacks = zip((g - nlp.cl)[rows].tolist(), (nlp.cu - g)[rows].tolist(), strict=True)
        bounds = dict(zip(self.names(suffix), self.bounds, strict=True))
        if suffix == ".tex":
            bounds |= {name: (t, t) for name, t in self.values(suffix).items() if name not in bounds}
        return Program(nlp.objective(self.z), dict(zip(names, slacks, strict=True)), bounds)


def tex_name(name: str, several: bool = False) -> str:
    """phase[main].x[q1,3] -> x_{q1,3}, or with several phases x_{main,q1,3}; phase[main].t0 -> t_{0}, t_{0,main}"""
    name = re.sub(r"t([0F])$", r"t[\1]", name.replace("'", ""))
    if phase := re.match(r"phase\[(\w+)\]\.", name):
        name, own = name[phase.end() :], phase[1]
        if several:
            name = re.sub(r"^t\[(.)\]$", rf"t[\1,{own}]", name) if name[0] == "t" else name.replace("[", f"[{own},", 1)
    return re.sub(r"^(\w)\[(.*)\]$", r"\1_{\2}", name)


def label(component: str, index: int | None, suffix: str) -> str:
    name = component if index is None else f"{component}[{index}]"
    return re.sub(r"\W", "_", name) if suffix == ".gms" else name


def check(reference: Reference, suffix: str, path: Path) -> None:
    export(reference.problem, reference.meshes, path)
    found, expected = READERS[suffix](path, reference.values(suffix)), reference.program(suffix)
    assert found.objective == pytest.approx(expected.objective, rel=1e-12)
    assert found.bounds == expected.bounds
    if suffix == ".tex":  # its constraints have labels
        found.constraints = dict(zip(expected.constraints, found.constraints.values(), strict=True))
    assert found.constraints.keys() == expected.constraints.keys()
    rounding = 16 * np.finfo(float).eps * np.abs(reference.z).max()  # of sums of terms as large as the unknowns
    for row, slacks in expected.constraints.items():
        assert found.constraints[row] == pytest.approx(slacks, rel=1e-9, abs=max(1e-12, rounding)), row


def of_file(path: Path, segments: int = 2) -> Reference:
    spec = load(path)
    return Reference(build(spec), replace(steps(spec.mesh)[-1], segments=segments, degree=None).mesh())


EACH = [(path, suffix) for first, suffix in enumerate(READERS) for path in share(FILES, 2 * len(READERS), 2 * first)]
"""Every second file in one of the formats; with TRAJOPT_SLOW every file in each."""


@pytest.mark.parametrize(("path", "suffix"), EACH, ids=lambda part: getattr(part, "stem", part))
def test_every_file(path, suffix, tmp_path):
    check(of_file(path), suffix, tmp_path / f"a{suffix}")


METHODS = [
    ("hermite-simpson-compressed", None, None),
    ("finite-difference", None, None),
    ("explicit-euler", None, None),
    ("gauss", 2, "integral"),
    ("gauss", 3, "differential"),
    ("radau", 3, "differential"),
    ("radau-left", 3, "differential"),
    ("lobatto", 4, "differential"),
    ("chebyshev", 4, "differential"),
]


@pytest.mark.parametrize(("how", "suffix"), crossed(METHODS, [*READERS]))
def test_every_kind_of_method(how, suffix, tmp_path):
    method, degree, form = how
    problem = build(load(shipped()["pendulum"]))
    check(Reference(problem, Mesh.of(find(method, degree, form), 3)), suffix, tmp_path / f"a{suffix}")


@FORMAT
@pytest.mark.parametrize("method", ["hermite-simpson", "hermite-simpson-compressed", "gauss"])
def test_everything_a_file_can_say(method, suffix, tmp_path):
    reference = Reference(build(load_text(MANY, "many.yaml")), Mesh.of(find(method), [1, 2, 1.5]))
    check(reference, suffix, tmp_path / f"a{suffix}")


@FORMAT
def test_segments_of_several_methods(suffix, tmp_path):
    mesh = Mesh((find("radau", 2), find("radau", 5), find("hermite-simpson"), find("radau", 2)), np.ones(4))
    check(Reference(build(load(shipped()["cartpole"])), mesh), suffix, tmp_path / f"a{suffix}")


# -- what the documents look like ------------------------------------------------------------------------------------


def test_a_document_of_the_cart_pole(folder):
    trajopt("export", "cartpole", "a.tex", "--segments", "2")
    lines = Path("a.tex").read_text().splitlines()
    assert lines[7:9] == [
        "25 unknowns, 16 constraints.",
        "Phase main: hermite-simpson; segments 1 to 2, points 0 to 4.",
    ]
    labels = [line for line in lines if line.startswith("Defect")]
    assert labels == [
        f"Defect of {state}, segment {segment}, row {row} of 2"
        for state in ("q1", "q2", "v1", "v2")
        for row in (1, 2)
        for segment in (1, 2)
    ]
    found = formulas(Path("a.tex"))
    assert found[5] == (
        r"- x_{q2,0} + x_{q2,2} = (t_{F} - t_{0})\cdot 0.5\,(0.16666666666666666\,x_{v2,0}"
        r" + 0.6666666666666666\,x_{v2,1} + 0.16666666666666666\,x_{v2,2})"
    )
    assert (
        found[-12:]
        == [
            "t_{0} = 0",
            "t_{F} = 2",
            "x_{q1,0} = 0",
            r"- 2 \leq x_{q1,k} \leq 2,\quad k = 1, 2, 3",
            "x_{q1,4} = 1",
            "x_{q2,0} = 0",
            r"- 6.283185307179586 \leq x_{q2,k} \leq 6.283185307179586,\quad k = 1, 2, 3",
            "x_{q2,4} = 3.141592653589793",
            r"x_{v1,k} = 0,\quad k = 0, 4",
            r"x_{v1,k} \text{ free},\quad k = 1, 2, 3",
            r"x_{v2,k} = 0,\quad k = 0, 4",
            r"x_{v2,k} \text{ free},\quad k = 1, 2, 3",
            r"- 20 \leq u_{u,k} \leq 20,\quad k = 0, 1, \dots, 4",
        ][-12:]
    )


@pytest.mark.parametrize(
    ("method", "labels"),
    [
        ("gauss", [f"Defect of q1, point {k}" for k in (5, 1, 2, 3)]),
        ("hermite-simpson-compressed", ["Defect of q1, segment 1", "Bounds of q1, point 1"]),
    ],
)
def test_labels(folder, method, labels):
    trajopt("export", "cartpole", "a.tex", "--segments", "1", "--method", method)
    assert [line for line in Path("a.tex").read_text().splitlines() if re.search(" of q1, ", line)][:4] == labels


def test_tex_reads_every_line(folder):
    """By Matplotlib's parser of mathematics, which has no parentheses of fixed sizes."""
    Path("many.yaml").write_text(MANY)
    trajopt("export", "many.yaml", "a.tex", "--segments", "1")
    text, parser = Path("a.tex").read_text(), MathTextParser("path")
    bodies = re.findall(r"\\begin\{align\*\}\n(.*?)\\end\{align\*\}", text, re.DOTALL)
    rows = [row for body in bodies for row in re.sub(r"\\bigg[lr]", "", body).split("\\\\\n")]
    assert len(rows) > 50
    for row in {re.sub(r"\d+", "0", row): row for row in rows}.values():
        assert row.startswith("& ") and len(row) < 400
        parser.parse(f"${row[2:].strip()}$")


def test_any_name_of_a_problem(folder):
    Path("a.yaml").write_text(re.sub("(?m)^name: .*", r'name: "two\\nlines # [θ] \\\\ _ . y"', MANY))
    for suffix in READERS:
        assert trajopt("export", "a.yaml", f"a{suffix}").exit_code == 0
    assert Path("a.nl").read_text(encoding="utf-8").splitlines()[1].split()[:2] == ["53", "62"]
    assert r"\section*{two lines \# [(U+03B8)] \textbackslash{} \_ . y}" in Path("a.tex").read_text().splitlines()


def test_a_large_program_is_written_fast(folder):
    for suffix in READERS:
        began = time.process_time()
        trajopt("export", "cartpole", f"a{suffix}", "--segments", "100", "--method", "hermite-simpson")
        assert time.process_time() - began < 5  # measured 0.4 to 0.6


# -- the command -----------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("name", "method", "variables", "constraints"),
    [
        ("cartpole", "hermite-simpson", 5 * 21, 8 * 10),  # states and control at 21 points, two defects a state
        ("cartpole", "trapezoid", 5 * 11, 4 * 10),
        ("cartpole", "hermite-simpson-compressed", 5 * 21 - 4 * 10, 4 * 10 + 2 * 10),  # bounds of q1, q2 at midpoints
        ("shot_put", "trapezoid", 4 * 11 + 2, 4 * 10 + 2),  # the final time and the angle; two boundary constraints
        ("bryson_denham", "trapezoid", 3 * 11, 2 * 10 + 11),  # a path constraint
    ],
)
def test_sizes(folder, name, method, variables, constraints):
    result = trajopt("export", name, "a.nl", "--segments", "10", "--method", method)
    assert result.stdout.split() == ["a.nl", "a.row", "a.col"]
    counts = [int(n) for n in Path("a.nl").read_text().splitlines()[1].split("#")[0].split()]
    assert counts[:3] == [variables, constraints, 1]
    assert len(Path("a.col").read_text().split()) == variables
    assert len(Path("a.row").read_text().split()) == constraints + 1


def test_refusals(folder):
    assert trajopt("export", "shot_put", "a.tex", "--segments", "2").exit_code == 0
    refused = trajopt("export", "shot_put", "a.tex")
    assert refused.exit_code == 3 and "--force" in refused.stderr
    assert trajopt("export", "shot_put", "a.tex", "--segments", "2", "--force").exit_code == 0
    other = trajopt("export", "shot_put", "a.mod")
    assert other.exit_code == 2 and ".nl, .gms, .tex" in other.stderr


@pytest.mark.parametrize("name", ["cartpole", "shot_put", "bryson_denham"])
def test_another_solver_finds_the_same_optimum(folder, name):
    """CasADi's reader of .nl and its own derivatives; the tests above need neither."""
    casadi = pytest.importorskip("casadi", reason="CasADi comes with the extra 'bench'")
    trajopt("export", name, "a.nl")
    nl = casadi.NlpBuilder()
    nl.import_nl("a.nl")
    program = {"x": casadi.vertcat(*nl.x), "f": nl.f, "g": casadi.vertcat(*nl.g)}
    options = {"print_level": 0, "sb": "yes", "tol": 1e-9, "bound_relax_factor": 1e-10}  # bounds as here
    found = casadi.nlpsol("ipopt", "ipopt", program, {"ipopt": options, "print_time": False})(
        x0=nl.x_init, lbx=nl.x_lb, ubx=nl.x_ub, lbg=nl.g_lb, ubg=nl.g_ub
    )
    spec = load(shipped()[name])
    ours = solve(build(spec), steps(spec.mesh)[-1:])
    assert ours.problem.sense * float(found["f"]) == pytest.approx(ours.objective, rel=1e-7)
