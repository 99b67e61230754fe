"""Unknowns that are too small or too large for absolute numbers in IPOPT: its distances from bounds, its tolerance.

Small ones. IPOPT moves an unknown that starts at or beside its only bound inside by kappa max(1, |bound|), kappa = 0.01
(Waechter and Biegler, Math. Program. 106, 2006, section 3.6), and regularises by as much for each unknown. Both have a
unit: a rate constant of 1e-6 per second starts ten thousand times too large, whatever was guessed, and the solve may
end at another optimum. Where that distance is more than the size of an unknown, the program is scaled, for IPOPT alone:
that unknown by its size, all others by 1.

Large ones. A constraint may be violated by 1e-8 in its unit. The defect of a state of 1e7 is a difference of terms that
have no such digit; and a free time of 1e5 seconds moves by steps of 1. Where a state is as large as LARGE, or a free
time as long as LONG, the units are small (metres from the centre of a planet), and the program is scaled: everything by
its size, free times by the duration, so that units do not matter.

Quadratures. A state that nothing over time depends on, such as a named integral, begins at zero, and may become
anything: the integral of a squared force is 1e6 where the force is guessed to be zero. Its defects then are all that
a line search sees. Its size is how far its rate takes it with all inputs that have two bounds halfway between the
middle and the upper one, and as guessed otherwise. That may be far too much where bounds are loose, which costs digits:
so it is MOST at most, and less than NOTABLE is left alone.

The size of another state or an input is its largest magnitude along the start (for large ones, of an input in bounds
half of what is between them); of a static parameter it is its guess. If that is 0, it is the value at which it begins
to act: with X the sizes of the states and T the duration,

    size = min over the states of  X / (T |df/dp|).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial

import numpy as np

from ...problems.probe import depends_on
from ...problems.problem import Phase
from ...problems.quantities import Function, Range, State, Variable
from ..layout import Transcription
from ..scaling import TIME
from .other import POINTS, slopes

KAPPA = 0.01
LARGE, LONG = 1e6, 1e4
NOTABLE, MOST = 1e3, 1e4


def extreme_sizes(transcription: Transcription, z: np.ndarray) -> Mapping[str, float] | None:
    """The sizes that IPOPT needs, as of `scaling.scale`; None where it needs none.

    transcription: what stands where.
    z: initial values of the unknowns, shape (n,).

    Name of each variable, and TIME, -> its size if a state is large; if none is, -> its size if it is small, else 1.
    """
    sizes = _of_large(transcription, z) or _of_small(transcription, z)
    quadratures = _of_quadratures(transcription)
    if not quadratures:
        return sizes
    return (sizes or {variable.name: 1.0 for variable, _ in _sizes(transcription, z)}) | quadratures


def _of_large(transcription: Transcription, z: np.ndarray) -> dict[str, float]:
    sizes = dict[str, float]()
    for variable, size in _sizes(transcription, z):
        sizes[variable.name] = max(size, sizes.get(variable.name, 0.0))
    states = [sizes[state.name] for layout in transcription.phases for state in layout.phase.states]
    free = [_duration(layout.phase) for layout in transcription.phases if (layout.t >= 0).any()]
    if max(states, default=0.0) < LARGE and max(free, default=0.0) < LONG:
        return {}
    for layout in transcription.phases:
        phase = layout.phase
        for own in phase.inputs:
            if np.isfinite([own.bounds.lower, own.bounds.upper]).all():
                sizes[own.name] = (own.bounds.upper - own.bounds.lower) / 2
        for own in (*phase.states, *phase.inputs):
            sizes[own.name] = sizes[own.name] or _acts_at(phase, own.name)
    sizes[TIME] = max(free, default=0.0)
    return {name: size for name, size in sizes.items() if 0 < size < np.inf}


def _of_quadratures(transcription: Transcription) -> dict[str, float]:
    sizes: dict[str, float] = {}
    for layout in transcription.phases:
        for state in filter(partial(_is_quadrature, layout.phase), layout.phase.states):
            sizes[state.name] = max(sizes.get(state.name, 0.0), _reached(layout.phase, state))
    return {name: min(size, MOST) for name, size in sizes.items() if size > NOTABLE}


def _is_quadrature(phase: Phase, state: State) -> bool:
    """Whether a state begins at zero, goes anywhere, and nothing over time depends on it."""
    known = state.bounds != Range() or state.initial != Range(0.0, 0.0) or state.final != Range()
    rates = [own.rate for own in phase.states] + ([phase.lagrange] if phase.lagrange else [])
    conditions = [own.function for own in (*phase.residuals, *phase.path, *phase.integral)]
    over_time: list[Function] = [*rates, *conditions]
    return not (known or phase.exact or any(depends_on(own, {state.name}) for own in over_time))


def _reached(phase: Phase, state: State) -> float:
    """How far the rate of a quadrature takes it, as far as that is known before the solution; 0 where it is not."""
    guess, s = phase.guess, np.linspace(0.0, 1.0, POINTS)
    values = {**guess.samples(s), **guess.parameters, "t": guess.initial_time + s * _duration(phase)}
    for own in phase.inputs:
        lower, upper = own.bounds.lower, own.bounds.upper
        if np.isfinite([lower, upper]).all():
            values[own.name] = np.full_like(s, (lower + 3 * upper) / 4)
    with np.errstate(all="ignore"):
        size = float(np.mean(np.abs(np.broadcast_to(state.rate(values, np), s.shape))) * _duration(phase))
    return size if np.isfinite(size) else 0.0


def _duration(phase: Phase) -> float:
    return phase.guess.final_time - phase.guess.initial_time


def _of_small(transcription: Transcription, z: np.ndarray) -> dict[str, float] | None:
    sizes: dict[str, float] = {}
    for variable, size in _sizes(transcription, z):
        sizes[variable.name] = min(sizes.get(variable.name, 1.0), size if _is_small(variable, size) else 1.0)
    return sizes if any(size < 1 for size in sizes.values()) else None


def _is_small(variable: Variable, size: float) -> bool:
    bounds = [bound for bound in (variable.bounds.lower, variable.bounds.upper) if np.isfinite(bound)]
    return len(bounds) == 1 and 0 < size < KAPPA * max(1.0, abs(bounds[0]))


def _sizes(transcription: Transcription, z: np.ndarray) -> Iterator[tuple[Variable, float]]:
    for layout in transcription.phases:
        for variables, rows in ((layout.phase.states, layout.x), (layout.phase.inputs, layout.u)):
            for variable, places in zip(variables, rows, strict=True):
                yield variable, float(np.abs(z[places[places >= 0]]).max(initial=0.0))
    for parameter, place in zip(transcription.problem.parameters, transcription.parameters, strict=True):
        acts = (_acts_at(layout.phase, parameter.name) for layout in transcription.phases)
        yield parameter, float(np.abs(z[place])) or min(acts)


def _acts_at(phase: Phase, name: str) -> float:
    """The value at which something that is 0 begins to act in a phase; infinite where it does not."""
    states, guess = [state for state in phase.states if depends_on(state.rate, {name})], phase.guess
    duration = _duration(phase)
    sizes = [np.abs(guess.values[state.name]).max(initial=0.0) for state in states]
    steepest = [np.abs(slope).max(initial=0.0) * duration for slope in slopes(phase, guess, name, states)]
    found = [float(size / slope) for size, slope in zip(sizes, steepest, strict=True) if size > 0 and slope > 0]
    return min(found, default=np.inf)
