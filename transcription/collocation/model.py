"""Problem + meshes -> a Pyomo model, filled by the builder of the method of each phase.

The model holds model.p[name], the static parameters to optimise, one block for each phase, model.phase[name], filled by
its builder, and model.cost. Every rule is called once, with an index placeholder (see `templates.templated`), so that
building the constraints costs the same for ten segments and for ten thousand.

The unknowns z are ordered point by point, times and parameters last, and so are the rows of what holds over time, as
they are numbered by the compiler: the matrix that IPOPT factorises is banded with a narrow border. For two segments s
of a scheme with one point inside each, what a row depends on is marked in its Jacobian:

    z =                  x_0 u_0   x_1 u_1   x_2 u_2   x_3 u_3   x_4 u_4    t_0 t_F    p
    defects, s = 0      [ *   *     *   *     *   *                      |   *   *  |  *  ]     one row for each state
    defects, s = 1      [                     *   *     *   *     *   *  |   *   *  |  *  ]     and row of L and R
    path, k = 0         [ *   *                                          |   *   *  |  *  ]
    ...                 [           *   *                                |   *   *  |  *  ]
    path, k = 4         [                                         *   *  |   *   *  |  *  ]
    boundary            [ *   *                                   *   *  |   *   *  |  *  ]
    integral            [ *   *     *   *     *   *     *   *     *   *  |   *   *  |  *  ]

In the differential form a defect has all states of its segment, but u of one or two of its points. With several phases,
the band of each follows that of the one before; links, on the ends of several, are the last rows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from contextlib import nullcontext
from typing import Any

import numpy as np

from ...problems.names.structure import Form
from ...problems.problem import Curves, Problem
from ...problems.quantities import Constraint as PathConstraint
from ...problems.quantities import Function
from ..constraint_kinds import kind_between
from ..layout import BETWEEN, Family, Layout, Transcription, places
from ..libraries.pyomo import AnyValue, Block, ConcreteModel, Constraint, Objective, Param, Var, pyomo
from ..measured.knots import knots_at
from ..method_kind import TIMES
from ..program.compiled import CompiledNLP
from ..program.compiler import compile_model
from ..program.templates import templated
from ..schemes.mesh import Mesh
from ..schemes.segment import KindOfMethod
from .builder import PhaseBuilder
from .differences import DifferenceBuilder
from .forms import forms_of
from .relations import between, bound
from .segments import CollocationBuilder

BUILDERS: dict[KindOfMethod, type[PhaseBuilder]] = {"collocation": CollocationBuilder, "differences": DifferenceBuilder}


def by_model(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves], templates: bool, values_only: bool = False
) -> Transcription:
    """The program of collocation schemes and finite differences, as `transcribe.transcribe`.

    problem: one that no method refuses.
    meshes: one for each phase.
    guess: one for each phase.
    templates: False for an ordinary, expanded model.
    values_only: as of `structure.form_of`.
    """
    forms = forms_of(problem, values_only) if templates else None
    model = ConcreteModel(problem.name)
    model.p = Var([p.name for p in problem.parameters])
    start = problem.start_of_parameters(guess)
    for parameter in problem.parameters:
        bound(model.p[parameter.name], parameter.bounds, start[parameter.name])
    model.phase = Block([phase.name for phase in problem.phases])
    p = {parameter.name: model.p[parameter.name] for parameter in problem.parameters}
    blocks = [model.phase[phase.name] for phase in problem.phases]
    data = [
        _data(block, form) for block, form in zip(blocks, forms.phases if forms else [None] * len(blocks), strict=True)
    ]
    linked = _data(model, forms.links if forms else None)
    builders = [
        BUILDERS[mesh.schemes[0].kind](block, p, own, phase, mesh)
        for block, own, phase, mesh in zip(blocks, data, problem.phases, meshes, strict=True)
    ]
    by_name = {builder.phase.name: builder for builder in builders}
    for builder in builders:
        builder.before = by_name.get(builder.phase.before)
    with templated() if forms else nullcontext():
        for builder, curves in zip(builders, guess, strict=True):
            builder.variables(curves)
            builder.constraints()
        links = _links(model, problem, builders, linked)
        measured = 0.0 if templates else sum(map(_residuals, builders))  # else `measured.program`
        model.cost = Objective(rule=lambda m: problem.sense * _cost(problem, builders, linked) + measured)
    unknowns = _Unknowns()
    layouts = tuple(_laid_out(builder, unknowns.place) for builder in builders)
    parameters = np.array([unknowns.place(model.p, own.name) for own in problem.parameters], int)
    families = (*(family for builder in builders for family in builder.families), *links)
    return Transcription(problem, model, tuple(unknowns.variables), layouts, parameters, families)


def compiled_model(transcription: Transcription, backend: str | None = None) -> CompiledNLP:
    """The nonlinear program of a templated model; its slots are those of `forms.numbers_as_data`.

    transcription: by `by_model`.
    backend: as of `compile_model`.
    """
    return compile_model(transcription.model, transcription.variables, backend, dict(_numbers(transcription)))


def _numbers(transcription: Transcription) -> Iterator[tuple[tuple[str, str], Any]]:
    """(phase, or BETWEEN; name of a parameter that is data, or of a given time) -> its Param or fixed variable."""
    model = transcription.model
    blocks = {phase.name: model.phase[phase.name] for phase in transcription.problem.phases}
    for phase, block in blocks.items():
        ends = zip(TIMES, (block.t0, block.tF), strict=True)
        yield from (((phase, name), leaf) for name, leaf in ends if leaf.fixed)
    for phase, block in {**blocks, BETWEEN: model}.items():
        if block.component("number") is not None:
            yield from (((phase, name), leaf) for name, leaf in block.number.items())


def _data(block: Any, form: Form | None) -> dict[str, Any]:
    """Numbers of the file that stay symbols: a Param of the block for each."""
    if form is None or not form.data:
        return {}
    block.number = Param(
        list(form.data),
        mutable=True,
        within=AnyValue,
        initialize={name: float(number) for name, number in form.data.items()},
    )
    return {name: block.number[name] for name in form.data}


def _links(model: Any, problem: Problem, builders: Sequence[PhaseBuilder], data: Mapping[str, Any]) -> list[Family]:
    """Add the constraints between phases to a model whose phases are filled, and tell what they are."""
    families = []
    for number, link in enumerate(problem.links):

        def rule(m: Any, *, c: PathConstraint = link) -> Any:  # Pyomo takes a positional one for an index
            return between(c.bounds, c.function({**_all_ends(builders), **data}, pyomo))

        constraint = Constraint(rule=rule)
        model.add_component(f"link{number}", constraint)
        families.append(Family(constraint, BETWEEN, kind_between(link), link.name, np.array([[0.0, 1.0]]), np.ones(1)))
    return families


def _all_ends(builders: Sequence[PhaseBuilder]) -> dict[str, Any]:
    """The values at the ends of all phases, by names such as "boost.q1[final]", and the static parameters."""
    values: dict[str, Any] = {}
    for builder in builders:
        values |= builder.p
        values |= {f"{builder.phase.name}.{name}": value for name, value in builder.ends().items()}
    return values


def _cost(problem: Problem, builders: Sequence[PhaseBuilder], data: Mapping[str, Any]) -> Any:
    cost = sum(builder.cost() for builder in builders)
    return cost + problem.mayer({**_all_ends(builders), **data}, pyomo) if problem.mayer else cost


def _residuals(builder: PhaseBuilder) -> Any:
    """The weighted squared residuals of the measurements of a phase, written out (see `measured.residuals`)."""
    phase, mesh, total = builder.phase, builder.mesh, 0.0
    for own in phase.measured:
        knots = mesh.knots[knots_at(mesh, phase.fractions_of(own.instants))]
        at = zip(knots.tolist(), own.instants.tolist(), strict=True)
        h = [_at_knot(builder, own.function, k, t) for k, t in at]
        if own.spans is not None:
            h = [(b - a) / d for a, b, d in zip(h[::2], h[1::2], np.diff(own.spans)[:, 0].tolist(), strict=True)]
        for one, y, w in zip(h, own.values.tolist(), own.weights.tolist(), strict=True):
            total += w * (one - y) ** 2
    return total


def _at_knot(builder: PhaseBuilder, function: Function, k: int, t: float) -> Any:
    """A function of states and parameters at the point k, a knot, whose time is t."""
    values = builder.at(k, [state.name for state in builder.phase.states], inputs=False)
    values["t"] = t
    return function(values, pyomo)


class _Unknowns:
    """The free variables of a model in the order of z."""

    def __init__(self) -> None:
        self.variables: list[Any] = []

    def place(self, component: Any, index: Any = None) -> int:
        """The number of a variable, which becomes the next unknown; -1 if there is none or it is fixed."""
        if index not in component or component[index].fixed:
            return -1
        self.variables.append(component[index])
        return len(self.variables) - 1


def _laid_out(builder: PhaseBuilder, place: Callable[..., int]) -> Layout:
    block, phase, mesh, inputs = builder.block, builder.phase, builder.mesh, builder.inputs
    x, u, t = places(
        phase,
        mesh,
        state=lambda i, k: place(block.x, (phase.states[i].name, k)),
        own_input=lambda i, k: place(block.end if (inputs[i][1], k) in block.end else inputs[i][0], (inputs[i][1], k)),
        time=lambda end: place(block.tF if end else block.t0),
    )
    explicit = "" if builder.explicit_set is None else builder.explicit_set.name
    return Layout(phase, mesh, x, u, t, builder.owners, explicit, builder.shared)
