"""A solution whose controls jump at the right times: there the Hamiltonian is the same on both sides of each jump.

With controls u- before and u+ after a jump at s, and H of the minimised objective (the corner condition of Weierstrass
and Erdmann; Bryson and Ho 1975, section 3.7),

    dJ/ds  =  H(x, lambda, u-) - H(x, lambda, u+)  =  0.

Where H has two minima over the controls, each point of a mesh is at one of them, and no small change takes it over the
hill between: the jump stays where the first mesh happened to have it. So the knots about it are moved instead. With the
costates as they are, the root of dJ/ds is a first step; the mesh with moved knots is solved from the solution before,
and a secant through both says where to go next.
"""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence

import numpy as np

from ...problems.lean.records import dataclass
from ..dual.multipliers import Multipliers
from ..engines.outcome import Start
from ..engines.watch import Limit, Watch
from ..layout import bounded_start
from ..measured.knots import measured_fractions
from ..one_mesh import Found, engine_of, in_place, measured
from ..refinement.switches import Switches
from ..schemes.mesh import Mesh
from ..settings import Settings
from ..solution.hamiltonian import minimise
from ..solution.lagrangian import PhaseLagrangian, Samples
from ..starts.settled import has_moving
from ..transcribe import Planned, program

MOVED = "controls jumped where the Hamiltonian is not the same before and after; such jumps were moved to where it is"

WORTH_IT = 0.01  # of the error bar: what the next step has to gain
MOST, FEW = 20, 100  # meshes with moved knots, and iterations of each
LONGEST = 4.0  # a step of the secant, in steps before it
A_LITTLE = 0.01  # of the phase: the first step at least
ROOM, FAR = 0.4, 0.05  # the longest step, of the way to the next jump or to the end of the phase; and of the phase
NEAR = 0.01  # of the phase: segments of one jump are nearer, and that far from it controls are what they are beside it
OF_HEIGHT = 0.3  # of a jump: how far from the controls beside it a minimum of H is still theirs
BETWEEN, HILL = 9, 1e-3  # controls between those beside a jump; H rises above its chord there by so much of dJ/ds
SAMPLES = 80  # of the way that a jump may go

Run = tuple[int, int, int]
"""Number of a phase, and the first and last of its segments over which a control jumps."""


@dataclass(frozen=True)
class Jump:
    """A jump of controls at normalised time s.

    slope: dJ/ds, per normalised time. step: to its root with the costates as they are. room: lower and upper limit of
    a step.
    """

    s: float
    slope: float
    step: float
    room: tuple[float, float]


@dataclass(frozen=True)
class Move:
    """Of a jump: how far, and what that gains to first and second order."""

    step: float
    gain: float


@np.errstate(all="ignore")
def at_corners(step: Planned, settings: Settings, found: Found, watch: Watch) -> Found | None:
    """The solution on knots that are moved with the jumps of controls; None if that is no better.

    step, settings: of the solve.
    found: what it led to.
    watch: who looks on.
    """
    problem, runs, bar = step[0], _runs(found), found[0].objective_error
    aligned = has_moving(problem) or any(len(measured_fractions(phase)) for phase in problem.phases)
    if not runs or not bar.applies or aligned or settings.engine != "ipopt":
        return None
    least = WORTH_IT * bar.bar
    best = last = found
    before, now = dict[Run, Jump](), _jumps(found, runs)
    limit, few = Limit(None, watch.stop), settings.within(FEW)
    for _ in range(MOST):
        moves = {run: _move(jump, before.get(run)) for run, jump in now.items()}
        if sum(move.gain for move in moves.values()) <= least or limit.reached():
            break
        moved = _on_moved(step, few, last, {run: (now[run].s, own.step) for run, own in moves.items()}, watch)
        if not moved[0].status.usable:
            break
        last = in_place(last, moved)
        before, now = now, _jumps(last, runs)
        if _at_worst(last) < _at_worst(best):
            best = last
        elif all(jump.slope * before[run].slope > 0 for run, jump in now.items()):
            break  # worse, and no jump has gone too far
    return best if _at_worst(best) < _at_worst(found) - least else None


def _at_worst(found: Found) -> float:
    """The minimised objective with its error bar."""
    solution = found[0]
    return solution.problem.sense * solution.objective + solution.objective_error.bar


def _runs(found: Found) -> list[Run]:
    """Where controls jump, with a segment of the phase on either side; what is near is one."""
    runs: list[Run] = []
    for number, tr in enumerate(found[0].trajectories):
        if tr.costate is None or tr.phase.exact or not tr.phase.controls or not tr.lasts:
            continue
        own, edges = list[Run](), tr.mesh.edges
        for s in sorted(Switches(tr).jumps):
            if own and edges[s] - edges[own[-1][2] + 1] <= NEAR:
                own[-1] = (*own[-1][:2], s)
            else:
                own.append((number, s, s))
        runs += [run for run in own if run[1] > 0 and run[2] < tr.mesh.segments - 1]
    return runs


def _jumps(found: Found, runs: Sequence[Run]) -> dict[Run, Jump]:
    """The jumps of a solution there."""
    solution, solved = found
    multipliers, jumps = Multipliers(solved.transcription, solved.nlp, solved.outcome), dict[Run, Jump]()
    for number, trajectory in enumerate(solution.trajectories):
        own = [run for run in runs if run[0] == number]
        if own:
            phase = PhaseLagrangian(number, multipliers, trajectory)
            edges = trajectory.mesh.edges
            s = [0.0, *((edges[first] + edges[last + 1]) / 2 for _, first, last in own), 1.0]
            for run, low, at, high in zip(own, s[:-2], s[1:-1], s[2:], strict=True):
                jumps[run] = _jump(phase, run, at, (max(ROOM * (low - at), -FAR), min(ROOM * (high - at), FAR)))
    return jumps


def _jump(phase: PhaseLagrangian, run: Run, at: float, room: tuple[float, float]) -> Jump:
    """One of them, with the least H next to the controls on either side of it: u- and u+ at every time.

    Without a hill of H between them, as where it is linear in the controls, a jump finds its place by itself.
    """
    edges, (_, first, last) = phase.mesh.edges, run
    near = _samples(phase, np.union1d(np.linspace(at + room[0], at + room[1], SAMPLES), [at]))
    beside = np.array([max(edges[first] - NEAR, at + room[0]), min(edges[last + 1] + NEAR, at + room[1])])
    u = phase.trajectory.at(beside).u[: phase.n]
    reach = OF_HEIGHT * np.abs(u[:, 1] - u[:, 0])
    hamiltonian, constrained = phase.over_controls(near)
    sides = np.clip([u.T - reach, u.T + reach], *phase.control_bounds[:, None])
    starts = (np.outer(own, np.ones(len(near.s))) for own in u.T)
    before, after = (
        minimise(hamiltonian, start, within, constrained)
        for start, within in zip(starts, sides.swapaxes(0, 1), strict=True)
    )
    s, slopes, here = near.s, phase.duration * (before.value - after.value), np.flatnonzero(near.s == at)
    (slope,) = slopes[here].tolist()
    between = before.u[:, here] + np.linspace(0, 1, BETWEEN) * (after.u - before.u)[:, here]
    hill = hamiltonian(between[:, :, None], here)[:, 0]
    above = phase.duration * (hill - np.linspace(hill[0], hill[-1], BETWEEN)).max()
    if not above > HILL * abs(slope) or not np.isfinite(slopes).all():
        return Jump(at, 0.0, 0.0, room)
    downhill = s > at if slope < 0 else s < at
    order = np.argsort(np.abs(s[downhill] - at))
    way, along = np.append(at, s[downhill][order]), np.append(slope, slopes[downhill][order])
    ends = np.flatnonzero(along[1:] * slope <= 0)
    if len(ends):
        n = ends[0]
        root = way[n] + along[n] / (along[n] - along[n + 1]) * (way[n + 1] - way[n])
    else:
        root = way[-1]
    return Jump(at, slope, float(root - at), room)


def _samples(phase: PhaseLagrangian, s: np.ndarray) -> Samples:
    """The phase at normalised times, (M,)."""
    at = phase.trajectory.at(s)
    assert at.costate is not None
    return Samples(at.t, s, at.x, at.dx, phase.sense * at.costate, at.u, np.ones((1, len(s))))


def _move(jump: Jump, before: Jump | None) -> Move:
    """By the secant through this and where it was before, if J is convex between them; at first, to the root with the
    costates as they are, or by a little if that gains more: fast states follow a jump, and hide where it belongs.
    """
    if before and (gone := jump.s - before.s):
        curvature = (jump.slope - before.slope) / gone
        longest = LONGEST * max(abs(gone), abs(jump.step))
        step = np.clip(-jump.slope / curvature, -longest, longest) if curvature > 0 else 2 * jump.step
    else:
        step = max(jump.step, -np.sign(jump.slope) * A_LITTLE, key=abs)
    step = float(np.clip(step, *jump.room))
    return Move(step, abs(jump.slope * step) / 2)


def _on_moved(
    step: Planned, settings: Settings, found: Found, moves: Mapping[Run, tuple[float, float]], watch: Watch
) -> Found:
    """The solution on the meshes with moved knots, from one before its knots were moved.

    step, settings: of the solve.
    found: the one before.
    moves: where each jump is, and how far it goes.
    watch: who looks on.
    """
    (problem, _, tolerance), (solution, solved) = step, found
    clock = [time.perf_counter()]
    own = [[move for (number, *_), move in moves.items() if number == i] for i in range(len(solution.trajectories))]
    meshes = [_moved(trajectory.mesh, its) for trajectory, its in zip(solution.trajectories, own, strict=True)]
    transcription, nlp, built = program(problem, meshes, solution.trajectories)
    clock += [built, time.perf_counter()]
    _, lower, upper = bounded_start(transcription)
    engine = engine_of(transcription, nlp, (lower, upper), solved.damping, settings, watch)
    before = solved.outcome
    start = Start(before.y, before.z_lower, before.z_upper)
    outcome = engine(before.z, {"tol": tolerance, **settings.options}, start)
    clock.append(time.perf_counter())
    return measured(transcription, nlp, outcome, solved.damping, tolerance, clock)


def _moved(mesh: Mesh, moves: Sequence[tuple[float, float]]) -> Mesh:
    """The mesh whose knots have gone with those that moved, each as near to them as it was."""
    s, steps = np.array([(0.0, 0.0), *moves, (1.0, 0.0)]).T
    return Mesh(mesh.schemes, np.diff(np.interp(mesh.edges, s, s + steps)))
