"""One compilation serves every number: a kept program with other numbers is the program that they would have made."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from named import ALL, share
from repository import ROOT

from trajopt.problems.build import build
from trajopt.problems.catalog import shipped
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load, load_text
from trajopt.transcription.collocation import kept
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import schedule_of, settings_of
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, program, transcribe

FILES = sorted((ROOT / "problems").glob("*.yaml"))
GAUSS = find("gauss", 3, None)


@pytest.fixture(autouse=True)
def _in_memory_only(monkeypatch):
    """What is on the disk is tested in tests/transcription/cache."""
    monkeypatch.setenv("TRAJOPT_CACHE", "off")


POWERS = """
trajopt: 1
name: numbers that the form depends on
parameters: {n: 3, c: 0.5, floor: 0.2, low: 0.1, scale: 1.0, limit: 4.0}
expressions: {half: n/2, part: "scale*x**half"}
time: {initial: 0, final: 1}
states: {x: {rate: "-c*x**n + u", initial: 1, lower: low}}
controls: {u: {lower: -limit, upper: limit}}
objective: {minimize: {integral: "scale*u**2 + part**2 + max(floor, 0.1)*x", terminal: "(x[final] - c)**2"}}
constraints: {path: [{name: sum, expression: "scale*x + c*u", upper: limit}]}
"""


def moved(spec, factor):
    """Overrides that change every parameter that is a number and in the file."""
    return [f"parameters.{n}={p.value.constant() * factor!r}" for n, p in spec.parameters.items() if not p.value.names]


def assert_same(one, other):
    """The same numbers and structure to rounding."""
    (first, a), (second, b) = one, other
    for x, y in zip((*bounded_start(first), a.cl, a.cu), (*bounded_start(second), b.cl, b.cu), strict=True):
        np.testing.assert_array_equal(x, y)
    structures = [(*nlp.jacobianstructure(), *nlp.hessianstructure()) for nlp in (a, b)]
    for x, y in zip(*structures, strict=True):
        np.testing.assert_array_equal(x, y)
    random = np.random.default_rng(0)
    start, lower, upper = bounded_start(first)
    z = np.clip(start + random.uniform(0.01, 0.1, len(start)), lower, upper)
    weights = random.uniform(-1, 1, a.m)
    with np.errstate(all="ignore"):
        np.testing.assert_allclose(a.constraints_unchecked(z), b.constraints_unchecked(z), 1e-13, 1e-13)
        if not np.isfinite(a.constraints_unchecked(z)).all():
            return
    assert a.objective(z) == pytest.approx(b.objective(z), rel=1e-13, abs=1e-13)
    for own, theirs in (
        (a.gradient(z), b.gradient(z)),
        (a.jacobian(z), b.jacobian(z)),
        (a.hessian(z, weights, 1.0), b.hessian(z, weights, 1.0)),
    ):
        np.testing.assert_allclose(own, theirs, 1e-12, 1e-12 * (1 + np.abs(own).max(initial=0.0)))


def meshes_of(problem):
    return [Mesh.of(GAUSS, 4) for _ in problem.phases]


@pytest.mark.parametrize("path", share(FILES, 4), ids=lambda path: path.stem)
def test_other_numbers_in_every_shipped_problem(path):
    spec = load(path)
    first = build(spec)
    program(first, meshes_of(first))
    for factor in (1.0009765625, 0.9990234375) if ALL else (1.0009765625,):
        try:
            other = build(load(path, moved(spec, factor)))
        except SpecError:  # these numbers go together
            continue
        transcription = transcribe(other, meshes_of(other))
        assert_same(program(other, meshes_of(other))[:2], (transcription, compiled(transcription)))


@pytest.mark.parametrize("name", ["cartpole", "goddard", "schwartz_two_phase", "two_phase_robot", "bryson_denham"])
def test_a_case_that_differs_in_numbers_compiles_nothing(name):
    spec = load(shipped()[name])
    first = build(spec)
    program(first, meshes_of(first))
    other = build(load(shipped()[name], moved(spec, 1.0009765625) or ["guess=linear"]))
    assert program(other, meshes_of(other)).nlp.seconds == dict.fromkeys(("differentiate", "compile", "evaluate"), 0.0)


@pytest.mark.parametrize(
    ("override", "same"),
    [
        ("parameters.c=0.7", True),
        ("parameters.scale=2.5", True),
        ("parameters.limit=3", True),
        ("parameters.low=-2", True),  # only a bound
        ("parameters.n=2", False),  # an exponent, by itself and through the expression half
        ("parameters.floor=0.05", False),  # under max
        ("parameters.c=0", False),
        ("states.x.upper=9", False),  # a bound where there was none
        ("states.x.final=0.5", False),
        ("objective.minimize.terminal=0*x[final]", False),
    ],
)
def test_what_belongs_to_the_form(override, same):
    first = build(load_text(POWERS, "powers.yaml"))
    program(first, meshes_of(first))
    other = build(load_text(POWERS, "powers.yaml", [override]))
    again = program(other, meshes_of(other))
    assert (again.nlp.seconds["differentiate"] == 0) == same
    transcription = transcribe(other, meshes_of(other))
    assert_same(again[:2], (transcription, compiled(transcription)))


def test_a_parameter_that_comes_from_zero():
    zero, half = (build(load_text(POWERS, "powers.yaml", [f"parameters.c={c}"])) for c in (0, 0.5))
    for problem in (zero, half, zero):
        transcription = transcribe(problem, meshes_of(problem))
        assert_same(program(problem, meshes_of(problem))[:2], (transcription, compiled(transcription)))


def test_an_earlier_program_keeps_its_numbers():
    """Refinement holds on to the program of the mesh before while others are made."""
    problems = [build(load_text(POWERS, "powers.yaml", [f"parameters.scale={s}"])) for s in (1, 2, 1)]
    first, second, third = (program(problem, meshes_of(problem)).nlp for problem in problems)
    z = np.linspace(0.5, 1.5, first.n)
    assert first.objective(z) == third.objective(z) != second.objective(z)
    assert first.objective(z) == third.objective(z)


def test_no_more_programs_are_kept_than_told():
    problem = build(load_text(POWERS, "powers.yaml"))
    for segments in range(1, kept.MOST + 6):
        program(problem, [Mesh.of(GAUSS, segments)])
    assert len(kept._kept) == kept.MOST
    assert program(problem, [Mesh.of(GAUSS, kept.MOST + 5)]).nlp.seconds["differentiate"] == 0
    assert program(problem, [Mesh.of(GAUSS, 1)]).nlp.seconds["differentiate"] > 0


def test_large_programs_push_out_others_and_too_large_ones_are_not_kept(monkeypatch):
    problem = build(load_text(POWERS, "powers.yaml"))
    sizes = {n: program(problem, [Mesh.of(GAUSS, n)]).nlp.n for n in (2, 3, 4)}
    monkeypatch.setattr(kept, "UNKNOWNS", sizes[3] + sizes[4])
    program(problem, [Mesh.of(GAUSS, 40)])
    for segments in (2, 3, 4):
        program(problem, [Mesh.of(GAUSS, segments)])
    program(problem, [Mesh.of(GAUSS, 5)])  # no room for 4 beside it, as 3 + 4 are all
    assert sum(own.nlp.n for own in kept._kept.values()) <= sizes[3] + sizes[4]
    assert program(problem, [Mesh.of(GAUSS, 5)]).nlp.seconds["differentiate"] == 0
    assert program(problem, [Mesh.of(GAUSS, 40)]).nlp.seconds["differentiate"] > 0


def objective(mass):
    spec = load(shipped()["cartpole"], [f"parameters.m1={mass}"])
    return solve(build(spec), schedule_of(spec), settings_of(spec)).objective


def test_threads_at_once_have_their_own_numbers():
    masses = [0.8, 0.9, 1.0, 1.1, 1.2, 1.3]
    alone = [objective(mass) for mass in masses]
    with ThreadPoolExecutor(3) as pool:
        assert list(pool.map(objective, masses)) == alone
    assert len(set(alone)) == len(masses)


def test_a_link_and_a_boundary_constraint_of_one_name_are_no_form_of_each_other():
    text = """
trajopt: 1
time: {initial: 0, final: 2}
states: {x: {rate: u, initial: 0}}
controls: {u: {}}
phases: {a: {time: {final: 1}}, b: {}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 3}]
"""
    constraint = '{name: c, expression: "b.x[final] - a.x[initial]", equals: 1}'
    kinds = []
    for more in (f"links: [a, {constraint}]", f"constraints: {{boundary: [{constraint}]}}"):
        spec = load_text(text + more.replace("[a, ", "[{from: a, to: b}, "), "x.yaml")
        made = program(build(spec), [step.mesh() for step in schedule_of(spec)[0]], None)[0]
        kinds.append(next(own.kind.name for own in made.families if own.name == "c"))
    assert kinds == ["link", "ends"]
