"""The nonlinear program of a shooting method: exact derivatives, its unknowns, the names of its rows."""

import numpy as np
import pytest
from derivatives import check_derivatives
from exact import growth, integration
from named import crossed, problem_named

from trajopt.problems.problem import Problem
from trajopt.problems.quantities import Constraint, Range
from trajopt.transcription.constraint_kinds import BOUND, PATH
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.program.contract import NotFinite
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.settings import Step
from trajopt.transcription.transcribe import compiled, transcribe


def two_phases() -> Problem:
    """Two phases with different times, a parameter, and every kind of constraint; maximised."""
    (first,), (second,) = problem_named("brachistochrone").phases, growth().phases
    integral = Constraint("effort", lambda v, m: v["u"] ** 2 * m.exp(v["t"]), Range(upper=3.0))
    path = Constraint("speed", lambda v, m: v["u"] * v["x"] + v["t"] ** 2, Range(-9.0, 9.0))
    ends = Constraint("ends", lambda v, m: v["x[final]"] * v["u[initial]"] + v["u[final]"] ** 2, Range(-5.0, 5.0))
    second = type(second)(**{**vars(second), "name": "second", "integral": (integral,), "path": (path,),
                             "boundary": (ends,), "mayer": lambda v, m: v["x[final]"] ** 3})  # fmt: skip
    return Problem("two", -1, (first, second))


DERIVATIVES = {
    name: (lambda name=name: problem_named(name))
    for name in ("cartpole", "cartpole_min_time", "bryson_denham", "shot_put", "brachistochrone", "block_move_min_work")
} | {"two phases": two_phases, "integration": integration}


HOW = [("runge-kutta-2", 3, "constant"), ("runge-kutta-4", 2, "quadratic"), ("dormand-prince", 2, "linear")]


@pytest.mark.parametrize(("name", "how"), crossed([*DERIVATIVES], HOW))
def test_derivatives_are_exact(name, how):
    method, substeps, control = how
    problem = DERIVATIVES[name]()
    scheme, other = find(method, substeps=substeps, control=control), find("runge-kutta-4", substeps=1, control=control)
    mesh = Mesh((scheme, other, scheme), np.array([1.0, 2.0, 1.5]))
    transcription = transcribe(problem, [mesh] * len(problem.phases))
    nlp, generator = compiled(transcription), np.random.default_rng(1)
    z, _, _ = bounded_start(transcription)
    z = z + 0.05 * generator.standard_normal(nlp.n) * (1 + np.abs(z))
    check_derivatives(nlp, z)


def test_a_segment_does_not_depend_on_controls_to_come():
    transcription = transcribe(problem_named("bryson_denham"), [Mesh.of(find("runge-kutta-4", substeps=3), 2)])
    nlp, (layout,) = compiled(transcription), transcription.phases
    limit = next(f for f in transcription.families if f.kind in (PATH, BOUND))
    rows, columns = nlp.jacobianstructure()
    for row, time in zip(limit.rows(nlp), limit.span[:, 0], strict=True):
        later = layout.u[:, layout.mesh.fractions > time + 0.1].ravel()  # a middle sees the end of its substep
        assert not np.isin(columns[rows == row], later).any()


@pytest.mark.parametrize(("control", "nodes"), [("constant", 1), ("linear", 1), ("quadratic", 2)])
def test_number_of_unknowns(control, nodes):
    step = Step("runge-kutta-4", 10, 1e-8, substeps=5, control=control)
    (mesh,) = transcribe(problem_named("cartpole"), [step.mesh()]).phases
    unknowns = len(transcribe(problem_named("cartpole"), [step.mesh()]).variables)
    assert (mesh.x >= 0).sum() == 4 * 11  # states at the ends of the segments only
    assert unknowns == 4 * 11 + nodes * 50 + (control != "constant")
    assert (
        len(transcribe(problem_named("brachistochrone"), [step.mesh()]).variables)
        == 3 * 11 + nodes * 50 + (control != "constant") + 1
    )


def test_rows_are_told_by_name():
    transcription = transcribe(problem_named("bryson_denham"), [Mesh.of(find("runge-kutta-4", substeps=2), 3)])
    nlp = compiled(transcription)
    for family in transcription.families:
        rows = family.rows(nlp)
        assert len(rows.ravel()) == len(family.span)
        assert nlp.row_name(int(rows.ravel()[-1]))[0] == f"{family.kind} {family.name}"


def test_what_is_not_finite_is_told_by_segment():
    transcription = transcribe(problem_named("hyper_sensitive"), [Mesh.of(find("runge-kutta-4", substeps=3), 3)])
    nlp = compiled(transcription)  # steps of 1000 s blow up
    z = np.full(nlp.n, 1.5)
    with pytest.raises(NotFinite, match="simulation of segment 1"):
        nlp.hessian(z, np.ones(nlp.m), 1.0)
