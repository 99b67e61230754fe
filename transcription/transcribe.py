"""Problem + meshes -> Transcription: a Pyomo model, its unknowns in order, and what stands where.

The model holds model.p[name], the static parameters to optimise, one block for each phase, model.phase[name], filled by
the builder of its scheme (`collocation`, `finite_difference`), and model.cost. Every rule is called once, with an index
placeholder (see `templates.templated`), so that building the constraints costs the same for ten segments and for ten
thousand. The unknowns z are ordered point by point, (x_0, u_0, x_1, u_1, ...), times and parameters last: the matrix
that IPOPT factorises is banded with a narrow border.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext

import numpy as np
from pyomo.core import Block, ConcreteModel, Objective, Var

from ..problems.errors import Mistake, SpecError
from ..problems.problem import Problem
from .collocation.builder import bound
from .collocation.differences import DifferenceBuilder
from .collocation.differences import refused as not_for_differences
from .collocation.segments import CollocationBuilder
from .layout import Layout, Transcription
from .program.templates import templated
from .schemes.mesh import Mesh
from .schemes.runge_kutta import Shooting
from .schemes.scheme import FiniteDifference

MAX_UNKNOWNS = 5_000_000  # some 10 GB of Pyomo variables and matrix factors: refused before any memory is taken


def transcribe(problem: Problem, meshes: Sequence[Mesh], guess=None, templates: bool = True) -> Transcription:
    """Transcribe a problem on one mesh for each of its phases.

    guess: one for each phase, with the methods of `problems.problem.Guess`; by default the problem's own.
    templates=False gives an ordinary, expanded Pyomo model, for Pyomo's writers.
    Raises SpecError if there is no such nonlinear program, or it would be too large to hold.
    """
    if mistakes := list(refused(problem, meshes)):
        raise SpecError(mistakes)
    guess = guess or [phase.guess for phase in problem.phases]
    if isinstance(meshes[0].schemes[0], Shooting):
        return _transcribe_shooting(problem, meshes, guess, templates)
    model = ConcreteModel(problem.name)
    model.p = Var([p.name for p in problem.parameters])
    for parameter in problem.parameters:
        bound(model.p[parameter.name], parameter.bounds, guess[0].parameters[parameter.name])
    model.phase = Block([phase.name for phase in problem.phases])
    p = {parameter.name: model.p[parameter.name] for parameter in problem.parameters}
    builders = [
        _builder(mesh)(model.phase[phase.name], p, phase, mesh)
        for phase, mesh in zip(problem.phases, meshes, strict=True)
    ]
    with templated() if templates else nullcontext():
        for builder, start in zip(builders, guess, strict=True):
            builder.variables(start)
            builder.constraints()
        model.cost = Objective(rule=lambda m: problem.sense * sum(builder.cost() for builder in builders))
    return _lay_out(problem, model, builders)


def _transcribe_shooting(problem: Problem, meshes: Sequence[Mesh], guess: Sequence, templates: bool) -> Transcription:
    from .shooting.rows import transcribe as transcribe_shooting

    if not templates:
        what = "a simulation has no equations to write down, so a shooting method cannot be exported"
        raise SpecError(Mistake("mesh", what, "export with another method, as --method hermite-simpson"))
    return transcribe_shooting(problem, meshes, guess)


def compiled(transcription: Transcription):
    """The nonlinear program of a transcription: a CompiledNLP, or a ShootingNLP with the same callbacks."""
    if transcription.model is None:
        from .shooting.program import ShootingNLP

        return ShootingNLP(transcription)
    from .program.compiler import CompiledNLP

    return CompiledNLP(transcription.model, transcription.variables)


def _builder(mesh: Mesh) -> type:
    return DifferenceBuilder if isinstance(mesh.schemes[0], FiniteDifference) else CollocationBuilder


def refused(problem: Problem, meshes: Sequence[Mesh]) -> Iterator[Mistake]:
    """Why a problem cannot be transcribed on these meshes."""
    unknowns = sum(
        len(mesh.fractions) * (len(phase.states) + len(phase.inputs))
        for phase, mesh in zip(problem.phases, meshes, strict=True)
    )
    if unknowns > MAX_UNKNOWNS:
        what = f"{unknowns} unknowns are more than the {MAX_UNKNOWNS} that trajopt takes"
        yield Mistake("mesh", what, "use fewer segments")
    for phase, mesh in zip(problem.phases, meshes, strict=True):
        scheme = mesh.schemes[0]
        if isinstance(scheme, FiniteDifference):
            yield from not_for_differences(phase, mesh)
        elif isinstance(scheme, Shooting):
            from .shooting.rows import refused as not_for_shooting

            yield from not_for_shooting(problem, phase, mesh)


def _lay_out(problem: Problem, model: ConcreteModel, builders: Sequence) -> Transcription:
    variables, phases = [], []

    def place(component, index=None) -> int:
        if index not in component:
            return -1
        variable = component[index]
        if variable.fixed:
            return -1
        variables.append(variable)
        return len(variables) - 1

    for builder in builders:
        block, phase, mesh = builder.block, builder.phase, builder.mesh
        x = np.full((len(phase.states), len(mesh.fractions)), -1)
        u = np.full((len(phase.inputs), len(mesh.fractions)), -1)
        for k in range(len(mesh.fractions)):
            for i, state in enumerate(phase.states):
                x[i, k] = place(block.x, (state.name, k))
            for i, (component, name) in enumerate(builder.inputs):
                u[i, k] = place(component, (name, k))
        t = np.array([place(block.t0), place(block.tF)])
        phases.append(Layout(phase, mesh, x, u, t, builder.owners, id(builder.explicit_set)))
    parameters = np.array([place(model.p, p.name) for p in problem.parameters], int)
    families = tuple(family for builder in builders for family in builder.families)
    return Transcription(problem, model, tuple(variables), tuple(phases), parameters, families)
