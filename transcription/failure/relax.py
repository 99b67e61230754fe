"""What would have to give way for a problem to have a solution: by name, phase and time, and by how much.

Dynamics, residuals and the consistency of algebraic variables are what they are; everything else may be relaxed: values
and times at the ends, constraints, bounds. First all of it may. That tells whether the problem is feasible, and which
few would have to give way together. Then each suspect may by itself, while all others are dear: the least by which it
has to be relaxed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property
from itertools import product
from math import inf

import numpy as np

from ...problems.lean.records import dataclass
from ...problems.problem import Curves, Phase, Problem
from ...problems.quantities import Range
from ..engines.ipopt import solve_program
from ..engines.outcome import Outcome
from ..layout import Transcription, bounded_start
from ..program.contract import NonlinearProgram
from ..schemes.mesh import Mesh
from ..solution.trajectory import Trajectory, trajectories
from ..solution.violation import times_at, when_between
from ..starts.other import both_sides, other_starts
from ..transcribe import MORE_SEGMENTS, divided, may_be_divided, program
from .elastic import ElasticProgram, Soft
from .soft import soft_constraints

RELAXED = 1e-4  # relative to the size of a constraint: what is relaxed by less holds
ACTS = 1e-3  # of the largest price of a multiplier: a suspect
SUSPECTS = 10  # are tried one by one
ORIGINS = 2  # for each suspect, beside the point of least violation
DEAR = 1e3  # times the price of what is tried: others give way only if it does not suffice
BEYOND = 0.01  # of the relaxation, beyond the bound: there it is needed
SHORTEST = 1e-3  # of the guessed duration: a phase stays that long
ITERATIONS = 300
POINTS = 120  # of a mesh, at most

DOUBTED = {"expect_infeasible_problem": "yes"}
"""Of IPOPT, where nothing may give way: it then looks for less violation sooner. A budget that cannot be kept is given
up after 15 iterations, not 300."""


@dataclass(frozen=True)
class Relaxation:
    """One constraint that gives way.

    before, after: its range; both are fixed if it demands a value. start, end: the times between which it has to give
    way, or None for what holds once. share: by how much, relative to its size.
    """

    phase: str
    what: str
    unit: str
    before: Range
    after: Range
    start: float | None
    end: float | None
    share: float

    def __str__(self) -> str:
        unit = f" {self.unit}" if self.unit not in ("", "1") else ""
        when = "" if self.start is None or self.end is None else when_between(self.start, self.end)
        moved = [
            (end, old, new)
            for end, old, new in (
                ("lower", self.before.lower, self.after.lower),
                ("upper", self.before.upper, self.after.upper),
            )
            if old != new
        ]
        if self.before.fixed or len(moved) == 1:
            end, old, new = moved[0]
            what = self.what.replace("the bounds of", f"the {end} bound of")
            return f"{what} from {old:.6g} to {new:.4g}{unit}{when}"
        before, after = (f"{side.lower:.4g} and {side.upper:.4g}" for side in (self.before, self.after))
        return f"{self.what} from {before} to {after}{unit}{when}"


@dataclass(frozen=True)
class Explanation:
    """Why a problem has no solution.

    feasible: nothing has to give way. curves: trajectories that satisfy everything then, else the least violation.
    alternatives: each of these would do by itself, the smallest change first. together: these would do together.
    settled: whether the elastic program was solved; otherwise nothing is known.
    """

    settled: bool
    feasible: bool
    curves: tuple[Trajectory, ...]
    alternatives: tuple[Relaxation, ...] = ()
    together: tuple[Relaxation, ...] = ()

    @property
    def relief(self) -> tuple[str, ...]:
        """What would have to give way, in words: each would do by itself."""
        if self.alternatives:
            return tuple(map(str, self.alternatives))
        return (" together with ".join(map(str, self.together)),) if self.together else ()


def explain(
    problem: Problem,
    meshes: Sequence[Mesh],
    guess: Sequence[Curves] | None = None,
    stop: Callable[[], bool] | None = None,
) -> Explanation:
    """What of a problem would have to give way.

    problem: any; its objective does not matter.
    meshes: one for each phase; large ones are made coarse.
    guess: where to start, one for each phase; None for the problem's own.
    stop: asked at each iteration; true ends the search, with what is known by then.

    Raises SpecError if the problem cannot be transcribed.
    """
    smaller = [mesh.coarsened(POINTS) or mesh if len(mesh.fractions) > POINTS else mesh for mesh in meshes]
    if (found := _feasible(problem, smaller, guess, stop)) is not None:
        return Explanation(True, True, found)
    search = _Search(problem, smaller, guess, stop)
    least = search.least()
    if not least.usable:
        return Explanation(False, False, ())
    together = tuple(least.relaxations)
    if not together:
        return Explanation(True, True, least.curves)
    if (found := _feasible_on_more(problem, smaller, guess, stop)) is not None:
        return Explanation(True, True, found)
    alternatives = sorted(search.alone(least), key=lambda own: own.share)
    return Explanation(True, False, least.curves, tuple(alternatives), together)


def _feasible(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves] | None, stop: Callable[[], bool] | None
) -> tuple[Trajectory, ...] | None:
    """Trajectories that satisfy everything, as the engine finds them with all constraints held and no objective."""
    transcription, nlp, _ = program(problem, meshes, guess)
    z = bounded_start(transcription)[0]
    found = _solved(transcription, nlp, [], z, np.zeros(0), stop)
    return found.curves if found.usable else None


def _feasible_on_more(
    problem: Problem, meshes: Sequence[Mesh], guess: Sequence[Curves] | None, stop: Callable[[], bool] | None
) -> tuple[Trajectory, ...] | None:
    """As `_feasible`, on more segments: few of them may contradict what the dynamics allow.

    Simulated states are tried, too.
    """
    starts = [guess, *(other.guesses for other in both_sides(problem, exactly=True))]
    for times, start in product(MORE_SEGMENTS, starts):
        if not may_be_divided(problem, meshes, times) or (stop and stop()):
            return None
        if (found := _feasible(problem, divided(problem, meshes, times), start, stop)) is not None:
            return found
    return None


@dataclass(frozen=True, eq=False)
class _Relaxed:
    """A solved elastic program."""

    transcription: Transcription
    elastic: ElasticProgram
    outcome: Outcome

    @property
    def usable(self) -> bool:
        return self.outcome.status.usable

    @property
    def z(self) -> np.ndarray:
        """The unknowns without the slacks."""
        return self.outcome.z[: self.elastic.inner.n]

    @cached_property
    def curves(self) -> tuple[Trajectory, ...]:
        return trajectories(self.transcription, self.z)

    @cached_property
    def relaxations(self) -> list[Relaxation]:
        return list(_relaxations(self.elastic, self.outcome, self.curves))


class _Search:
    """Elastic programs of one problem, whose times are free, from several starts: each finds a local least only."""

    def __init__(
        self,
        problem: Problem,
        meshes: Sequence[Mesh],
        guess: Sequence[Curves] | None,
        stop: Callable[[], bool] | None,
    ) -> None:
        loosened = replace(problem, phases=tuple(map(_with_free_times, problem.phases)))
        others = [other.guesses for other in other_starts(loosened, doubtful=False)]
        first, *rest = [program(loosened, meshes, own) for own in (guess, *others)]
        self.transcription, self.nlp, self.stop = first.transcription, first.nlp, stop
        self.soft = list(soft_constraints(problem, self.transcription, self.nlp))
        self.origins = [bounded_start(own.transcription)[0] for own in (first, *rest)]

    def least(self) -> _Relaxed:
        """The least violation found from any start."""
        found: list[_Relaxed] = []
        for origin in self.origins:
            if found and self._stopped():
                break
            found.append(self._from(origin, np.ones(len(self.soft))))
            if found[-1].usable and not found[-1].relaxations:
                break
        return min(found, key=lambda own: own.outcome.objective if own.usable else inf)

    def alone(self, least: _Relaxed) -> Iterator[Relaxation]:
        """Each suspect by itself, from where the violation is least, or from the other starts."""
        for suspect in _suspects(least.elastic, least.outcome):
            factors = np.where(np.arange(len(self.soft)) == suspect, 1.0, DEAR)
            for origin in (least.z, *self.origins[:ORIGINS]):
                if self._stopped():
                    return
                found = self._from(origin, factors)
                if found.usable and [own.what for own in found.relaxations] == [self.soft[suspect].what]:
                    yield found.relaxations[0]
                    break

    def _from(self, origin: np.ndarray, factors: np.ndarray) -> _Relaxed:
        return _solved(self.transcription, self.nlp, self.soft, origin, factors, self.stop)

    def _stopped(self) -> bool:
        return self.stop is not None and self.stop()


def _solved(
    transcription: Transcription,
    nlp: NonlinearProgram,
    soft: Sequence[Soft],
    start: np.ndarray,
    factors: np.ndarray,
    stop: Callable[[], bool] | None,
) -> _Relaxed:
    elastic = ElasticProgram(transcription, nlp, soft, start, factors)
    options = {"tol": 1e-7, "max_iter": ITERATIONS, **({} if soft else DOUBTED)}
    z, lower, upper = elastic.first(start), elastic.lower, elastic.upper
    return _Relaxed(transcription, elastic, solve_program(elastic, z, lower, upper, options, stop=stop))


def _with_free_times(phase: Phase) -> Phase:
    """The phase with times that are unknowns, but for a fixed initial one: only the duration matters then."""
    initial, guess = phase.initial_time, phase.guess
    shortest = SHORTEST * (guess.final_time - guess.initial_time)
    free = Range(initial.lower + shortest if initial.fixed else -inf, inf)
    return replace(phase, final_time=free)


# -- what is relaxed -----------------------------------------------------------------------------------------------


def _suspects(elastic: ElasticProgram, outcome: Outcome) -> list[int]:
    """What the least violation depends on, by its multipliers: times, what else holds once, then what acts most."""
    y = np.abs(outcome.y)
    forces = [float(y[rows].sum() * own.size) for rows, own in zip(elastic.rows_of, elastic.soft, strict=True)]
    acting = [j for j, force in enumerate(forces) if force > ACTS * max(forces)]
    kinds = [(not own.of_time, own.over_time) for own in elastic.soft]
    return sorted(acting, key=lambda j: (*kinds[j], -forces[j]))[:SUSPECTS]


def _relaxations(elastic: ElasticProgram, outcome: Outcome, curves: Sequence[Trajectory]) -> Iterator[Relaxation]:
    """What the values exceed, not the slacks: of these the barrier leaves some where nothing is exceeded."""
    phases = {curve.phase.name: curve for curve in curves}
    for own, g in zip(elastic.soft, elastic.values(outcome.z), strict=True):
        beyond = g - own.upper, own.lower - g
        up, down = (float(most) if most > RELAXED * own.size else 0.0 for most in (side.max() for side in beyond))
        if not up and not down:
            continue
        times: list[float | None] = [None, None]
        if own.over_time:
            s = own.s[np.maximum(*beyond) > BEYOND * max(up, down)]
            times = [*times_at(phases[own.phase], np.array([s.min(), s.max()]))]
        after = Range(_tidy(own.lower - down, own.size), _tidy(own.upper + up, own.size))
        if own.lower == own.upper:
            after = Range(*[_tidy(own.lower + up - down, own.size)] * 2)
        before, share = Range(own.lower, own.upper), max(up, down) / own.size
        yield Relaxation(own.phase, own.what, own.unit, before, after, times[0], times[1], share)


def _tidy(value: float, size: float) -> float:
    """The value, or 0 if it is nothing beside its size."""
    return 0.0 if abs(value) < RELAXED * size else float(value)
