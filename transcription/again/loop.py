"""The loop: solve on each mesh of a schedule, and on refined ones after it, each from the solution before."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import count

from ..engines.outcome import Status
from ..engines.watch import Limit, Watch
from ..first_mesh import solve_first_mesh
from ..one_mesh import Found, Origin, solve_mesh
from ..pontryagin.needles import Lower, lower_hamiltonian
from ..refinement.basin import STANDING, in_vain, left_basin, unmeasurable
from ..refinement.chatter import Damping, chatter, left_alone
from ..refinement.goal import Goal
from ..refinement.refine import MERGING_MESHES
from ..settings import Refine, Settings
from ..solution.solution import LARGEST_BAR, MeshRecord, Solution, with_error_bar
from ..transcribe import Planned, refused
from .completed import completed
from .corners import MOVED, at_corners
from .kept import Candidates, Kept
from .next_mesh import FIRST, accuracy, allowed_gap, asked_of_engine, meets_first, next_solve
from .same_mesh import SLOW, from_coarser, from_lower, sharpened, with_damping, with_short_turns
from .tightened import tightened

TOLD_TO_END = (Status.INTERRUPTED, Status.TIME_LIMIT)

OF_GAIN = 2.0
"""What other controls may gain, as a multiple of what the Hamiltonian says: that is of first order."""

WORTH_TELLING = 1e-5  # of 1 + |J|: less that other controls gain is in the error bar only

UNMINIMISED = (
    "this solution is stationary, and no minimum; another guess of the controls may lead to a better one, or a control "
    "that switches ever faster (chattering), which no mesh holds"
)

DAMPING_SHARE = 0.1
"""Of the accuracy that is asked for, relative to 1 + |J|: what the damping of controls that chatter may be worth."""

LOWERED, NOTICED = 3, 0.25
"""Times to start again with controls that have a lower Hamiltonian; and of the error bar, if it does not fall with the
mesh, what they have to gain."""


class Loop:
    """The solves of a schedule, and of the meshes that refinement adds to it.

    steps: the solves that are known, the first `scheduled` of the schedule. history: of every mesh that was solved.
    discarded: those whose solves were not kept.
    last: the solution to give back. candidates: those that may stand in its place. before_goal: meshes are refined by
    the error of their segments, before a finer goal for the objective. stopped: why no mesh came after its own. unmet:
    its segments that miss the tolerance. notes: what was done beyond what was asked. rough: controls chatter, and
    damping them is worse. weakest: controls chatter with weaker damping. lower: controls with a lower Hamiltonian than
    those of the last. gain: what such gain, of the last mesh that refinement has added. sharp: the barrier has left
    little of the last already.
    lowered: how often a better solution was looked for from such, most_lowered: at most; not at all from a guess that
    stands in place of the problem's own. cornered: how often jumps were moved; more: meshes before, after which as many
    may come as at first.
    """

    def __init__(
        self,
        steps: Sequence[Planned],
        settings: Settings,
        progress: Callable[[int, dict], None] | None,
        limit: Limit,
    ) -> None:
        self.steps, self.scheduled = list(steps), len(steps)
        self.settings, self.progress, self.limit = settings, progress, limit
        self.history: list[MeshRecord] = []
        self.last: Found | None = None
        self.candidates = Candidates(settings)
        self.before_goal = accuracy(settings.refine) < FIRST and bool(settings.refine and settings.refine.objective)
        self.stopped = ""
        self.unmet: tuple[str, ...] = ()
        self.notes: tuple[str, ...] = ()
        self.discarded: tuple[MeshRecord, ...] = ()
        self.rough = self.weakest = False
        self.lowered, self.cornered, self.most_lowered, self.more = 0, 0, LOWERED, 0
        self.sharp = False
        self.lower: Lower | None = None
        self.gain = 0.0

    def run(self, start: Origin) -> Solution:
        if start.guess is not None:
            self.most_lowered = 0
        for number in count():
            found = self._solved(number, start)
            if found is None:
                assert self.last is not None
                self.lower = lower_hamiltonian(*self.last, 1.0)
                break
            if self.settings.refine:
                found = self._sharpened(found, self.settings.refine)
            self._take(number, found)
            if not found[0].status.usable:
                self.unmet = ()  # they are of the mesh before
                break
            while other := self._lowered(number, found):
                del self.history[-len(found[0].meshes) :]
                found, self.candidates = other, Candidates(self.settings)
                self._take(number, found)
            start = Origin(found[0].trajectories, found[1], self._damping(found))
            if self.stopped or number + 1 == len(self.steps):
                break
            if self.limit.reached():
                why = "interrupted" if self.limit.asked() else "the time limit came"
                self.stopped = f"{why} before the next mesh"
                break
        self._back_to_the_best()
        return self._told()

    def _sharpened(self, found: Found, refine: Refine) -> Found:
        """The solution without what the barrier leaves; of a mesh before the goal, to what comes first."""
        if self.before_goal:
            found = sharpened(found, self.settings, FIRST, self._watch())
            self.before_goal = found[0].status.usable and not meets_first(found[0])
        return found if self.before_goal else sharpened(found, self.settings, accuracy(refine), self._watch())

    def _take(self, number: int, found: Found) -> None:
        """Make a solution the one to give back, and see what comes after it."""
        self.last, self.lower, self.sharp = found, None, self._settings(number).gap is not None
        self.history.extend(found[0].meshes)
        if found[0].status.usable and number + 1 >= self.scheduled:
            self.stopped = unmeasurable(found[0])
            if (asked := self.settings.refine) and not self.stopped:
                self._refine(number, found, Refine(FIRST, asked.max_meshes) if self.before_goal else asked)
        self.candidates.add(Kept(found, self.unmet, len(self.history)), number + 1 >= self.scheduled)

    def _back_to_the_best(self) -> None:
        assert self.last is not None
        missed = bool(self.unmet or self.stopped)
        while instead := self.candidates.instead_of(self.last, missed, self.stopped, self.history):
            back, self.stopped = instead
            self.last, self.unmet, self.sharp = back.found, back.unmet, False
            self.lower = lower_hamiltonian(*self.last, NOTICED)
            self.discarded += tuple(self.history[back.known :])
            del self.history[back.known :]

    def _lowered(self, number: int, found: Found) -> Found | None:
        """A better solution from controls with a lower Hamiltonian, on the same mesh; None if there is none. It is
        looked for on the first mesh that is refined, where the gain stays on the next, and where no mesh comes after.

        Where much is to be gained on one mesh as on the next, and no better solution is found, refinement ends: a
        control that switches ever faster (chattering) is held by no mesh.
        """
        at_end = bool(self.stopped) or number + 1 == len(self.steps)
        stays = None if at_end else self._stays_lower(number, found)
        if not (at_end or stays) and (number + 1 != self.scheduled or self.lowered == self.most_lowered):
            return None
        if (at_end or stays) and (moved := self._at_corners(number, found)):
            return moved
        self.lower = stays or lower_hamiltonian(*found, NOTICED if self.stopped else 1.0)
        if self.lower is None or self.limit.reached():
            return None
        other = None
        if self.lowered < self.most_lowered:
            self.lowered += 1
            other = from_lower(self.steps[number], self._settings(number), found, self.lower, self._watch())
        if other:
            before = f"other controls had a lower Hamiltonian along a solution of {found[0].objective:.6g}"
            self.notes += (f"{before}; from them a better one was found",)
            self.stopped, self.steps[number + 1 :], self.gain = "", (), 0.0
        elif stays and OF_GAIN * self.gain > LARGEST_BAR * (1 + abs(found[0].objective)):
            segments = found[0].meshes[-1].segments
            self.stopped = f"other controls have a lower Hamiltonian on {segments} segments as on fewer, by as much"
        return other

    def _at_corners(self, number: int, found: Found) -> Found | None:
        """The solution with jumps of controls where the Hamiltonian does not jump; None if that is no better."""
        if not self.settings.refine or self.cornered >= self.most_lowered:
            return None
        step = self.steps[number]
        moved = at_corners(step, self._settings(number), found, self._watch())
        if moved:
            self.cornered += 1
            self.notes = tuple(dict.fromkeys((*self.notes, MOVED)))
            self.more = number + 1 - self.scheduled
            self.steps[number:] = [_on_grids_of(moved, step)]
            self.stopped = ""
        return moved

    def _stays_lower(self, number: int, found: Found) -> Lower | None:
        """Controls with a lower Hamiltonian on a mesh that refinement has added, if they gain as much as on the one
        before."""
        if number < self.scheduled or not found[0].status.usable:
            return None
        lower, before = lower_hamiltonian(*found, 1.0), self.gain
        self.gain = lower.gain if lower and lower.gain > WORTH_TELLING * (1 + abs(found[0].objective)) else 0.0
        return lower if self.gain > STANDING * before > 0.0 else None

    def _solved(self, number: int, start: Origin) -> Found | None:
        """The solution on a mesh; None if it is none, or of another optimum, and the one before stands."""
        watch, settings = self._watch(), self._settings(number)
        if number:
            if number >= self.scheduled and self.last and self.last[0].is_no_trajectory:
                settings = settings.within(SLOW)
            found = from_coarser(self.steps[number], settings, start, watch, asked=number < self.scheduled)
        else:
            found = solve_first_mesh(*self.steps[number], settings, start, watch)
            self.steps[number] = _on_grids_of(found, self.steps[number])  # it may have more segments
        found = with_short_turns(self.steps[number], settings, found, start.damping, watch)
        solution, solved = self._calmed(number, found, watch)
        self.notes += solution.notes
        if solution.status is Status.INTERRUPTED and not self.limit.asked():
            solution = solution.out_of_time()
        if self.last is None:
            return solution, solved
        refined, own = number >= self.scheduled, self.steps[number][0] is self.steps[number - 1][0]
        if not solution.status.usable and (refined or (own and solution.status in TOLD_TO_END)):
            self.stopped = solution.meshes[-1].why_not_kept
            self.discarded += solution.meshes
            return None
        if refined and own and left_basin(self.last[0], solution, accuracy(self.settings.refine)):
            return self._again(number, (solution, solved), start, watch)
        return solution, solved

    def _calmed(self, number: int, found: Found, watch: Watch) -> Found:
        """The solution with damped controls where they chatter; as it is where they do not, or where that is worse."""
        solution, solved = found
        if self.rough or not self.settings.refine or self.settings.engine != "ipopt" or not solution.status.usable:
            return found
        if not (rough := chatter(solution.trajectories, solved.transcription)):
            return found
        damping = solved.damping.joined(rough, solution.objective)
        if len(damping.controls) == len(solved.damping.controls):
            damping, self.weakest = damping.stronger(), True
        calm = with_damping(self.steps[number], self.settings, found, damping, watch)
        self.rough = calm is None
        return calm or found

    def _damping(self, found: Found) -> Damping:
        """For the next solve: weaker if the mesh is good, but the damping worth more than its share of the accuracy."""
        solution, solved = found
        dear = solved.worth > DAMPING_SHARE * accuracy(self.settings.refine) * (1 + abs(solution.objective))
        return solved.damping.weaker() if dear and not self.unmet and not self.weakest else solved.damping

    def _again(self, number: int, left: Found, start: Origin, watch: Watch) -> Found | None:
        """A mesh whose solve left the basin, solved without the multipliers of the mesh before; None if that is no
        better, and the solution before stands."""
        assert self.last is not None
        found = solve_mesh(*self.steps[number], self.settings, Origin(start.guess, None, start.damping), watch)
        segments = left[0].meshes[-1].segments
        told = f"the mesh of {segments} segments led to another optimum, {left[0].objective:.8g}"
        if found[0].status.usable and not left_basin(self.last[0], found[0], accuracy(self.settings.refine)):
            self.notes += (f"{told}; solved again without multipliers, it leads to {found[0].objective:.8g}",)
            return found
        before = self.last[0].objective
        if self.last[0].problem.sense * (left[0].objective - before) > 0:
            why = f"which is worse than {before:.8g} by far more than both error bars"
        else:  # see `left_basin`
            why = f"which is not believed beside {before:.8g}, as the error of the dynamics has grown with it"
        self.stopped = f"{told}, {why}"
        return None

    def _refine(self, number: int, found: Found, refine: Refine) -> None:
        """Add the next mesh, if there is to be one, and say what is not good enough."""
        solution = found[0]
        merge = number + 1 - self.scheduled <= MERGING_MESHES
        left = self.scheduled + self.more + refine.max_meshes - len(self.steps)
        exact = min(self.steps[self.scheduled - 1][2], asked_of_engine(refine))  # what is looser shows in the error
        goal = Goal(refine.objective, solution) if refine.objective else None
        self.unmet, more = next_solve(self.steps[number], solution, refine, exact, merge, left, goal)
        if not self.unmet and not more and left > 0 and self._damping(found) != found[1].damping:
            more = [self.steps[number]]
        if goal and not self.unmet and not more:
            self.stopped = goal.unreachable
        barrier = goal.beyond_engine if goal else ""
        if more and (why := barrier or in_vain(self.history[self.scheduled - 1 :], refine.tolerance, refine.objective)):
            self.stopped = why
            return
        if too_large := [mistake for step in more for mistake in refused(*step[:2])]:
            self.stopped = f"the next mesh cannot be solved: {too_large[0].what}"
            return
        self.steps += more

    def _told(self) -> Solution:
        assert self.last is not None
        solution, solved = self.last
        if not self.sharp:
            gap = allowed_gap(self.settings.refine) * (1 + abs(solution.objective))
            solution, solved = tightened(self.last, self.settings, gap, self._watch())
        notes = (*self.notes, *solved.damping.told(solution.trajectories, solved.worth))
        if solution.status.usable and not self.settings.refine:
            notes += tuple(left_alone(solution.trajectories, solved.transcription))
        solution = replace(
            solution,
            meshes=(*self.history[:-1], solution.meshes[-1]),
            unmet=self.unmet,
            stopped=self.stopped,
            discarded=self.discarded,
            accept=self.settings.accept,
            notes=notes,
        )
        solution = completed(solution, solved)
        if not self.lower or not solution.objective_error.applies:
            return solution
        if self.lower.gain > WORTH_TELLING * (1 + abs(solution.objective)):
            told = f"another control has a lower Hamiltonian {self.lower.where}: {UNMINIMISED}"
            solution = replace(solution, notes=(*solution.notes, told))
        return self._widened(solution, self.lower.gain)

    def _widened(self, solution: Solution, gain: float) -> Solution:
        """The solution with what other controls may gain in its error bar, which then may miss the goal."""
        wider = with_error_bar(solution, solution.objective_error.bar + OF_GAIN * gain)
        asked = self.settings.refine and self.settings.refine.objective
        missed = Goal(asked, wider).missed if asked and not self.stopped and not self.unmet else ""
        return replace(wider, stopped=f"{missed}: other controls have a lower Hamiltonian") if missed else wider

    def _settings(self, number: int) -> Settings:
        """Of the solve of a mesh: with what the barrier may leave, where it is certain that no mesh comes after."""
        last = not self.settings.refine and number + 1 == len(self.steps)
        return replace(self.settings, gap=allowed_gap(None)) if last else self.settings

    def _watch(self) -> Watch:
        return Watch(self.progress, self.limit.reached, len(self.history))


def _on_grids_of(found: Found, step: Planned) -> Planned:
    """A solve as it was planned, but on the meshes of a solution."""
    problem, _, tolerance = step
    return problem, list(found[0].meshes[-1].grids), tolerance
