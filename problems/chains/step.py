r"""The step of a walker: its foot strikes, stays, and becomes the base, while the legs change roles.

Link j of the next step is link s(j) of this one; a leg is now passed the other way: its links point backwards. Angles
go on, and the impulse at the foot changes no momentum that the next step has: for each angle phi_j of the next step,
with c' and M of the next step and c, w of this one,

    sum_b M_jb cos(phi_j - phi_b) w_b [initial]  =  sum_b N_jb cos(phi'_j - phi_b) w_b [final]

    N_jb = sum_k m_k c'_kj c_s(k)b + sigma_j I_j (the last where b = s(j))        phi'_j = phi_s(j) + pi (1 - sigma_j)/2

where sigma_j is -1 for a link that is passed the other way, else 1,
the same as angular momentum about the foot and about the joints, (F.9) and (F.11)-(F.15) of Kelly 2017.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cached_property

import numpy as np

from ..lean.records import dataclass
from ..schema.model import StepEntry
from .angles import Angle, scaled_angle, summed
from .bodies import Body, Reach
from .motion import Chain

SAMPLES = 3
CLOSE = 1e-9
INITIAL, FINAL = "[initial]", "[final]"
BACKWARDS = Angle({}, 2)


@dataclass(frozen=True)
class Stride:
    """The step of a chain with a fixed base, absolute angles and no fixed joints."""

    chain: Chain
    entry: StepEntry

    @cached_property
    def before(self) -> list[int]:
        """s(j) of each link j."""
        swapped = {a: b for pair in self.entry.swap for a, b in (pair, pair[::-1])}
        return [self.chain.number_of(swapped.get(body.name, body.name)) for body in self.chain.bodies]

    @property
    def way(self) -> Reach:
        """The links on the way from one foot to the other."""
        return self.chain.bodies[self.chain.number_of(self.entry.foot)].tip

    def turned(self, j: Body) -> Angle:
        """phi'_j."""
        old = self.chain.bodies[self.before[j.number]]
        return Angle(old.phi.parts, old.phi.turns + (BACKWARDS.turns if old.number in self.way else 0))

    def constants(self) -> dict[str, str]:
        """Name -> value of each N_jb that is not zero."""
        bodies, found = self.chain.bodies, {}
        for j in bodies:
            for b in bodies:
                pairs = ((k, bodies[self.before[k.number]]) for k in bodies)
                shared = [
                    scaled_angle(k.constant("mass"), k.centre[j.number], old.centre[b.number])
                    for k, old in pairs
                    if j.number in k.centre and b.number in old.centre
                ]
                if b.number == self.before[j.number]:
                    shared.append(scaled_angle("-1" if b.number in self.way else "1", j.constant("inertia")))
                if shared:
                    found[carried(j, b)] = summed(shared)
        return found

    def conditions(self) -> dict[str, str]:
        """Name -> what is zero between the two ends of time: the angles that go on, then the momenta."""
        bodies, known, found = self.chain.bodies, self.constants(), {}
        for j in bodies:
            lag = (self.turned(j).turns - j.phi.turns + 1) % 4 - 1  # right angles, from -1 to 2
            (old,) = self.turned(j).parts
            found[f"step {j.q}"] = summed([f"{j.q}{INITIAL}", f"-{old}{FINAL}", f"-{lag}*pi/2" if lag else ""])
        for j in bodies:
            after, before = (at_end(angle, end) for angle, end in ((j.phi, INITIAL), (self.turned(j), FINAL)))
            terms = [
                scaled_angle(self.chain.mass(j, b), after.minus(at_end(b.phi, INITIAL)).cos, f"d{b.q}{INITIAL}")
                for b in bodies
                if self.chain.coupled(j, b)
            ]
            terms += [
                scaled_angle("-1", carried(j, b), before.minus(at_end(b.phi, FINAL)).cos, f"d{b.q}{FINAL}")
                for b in bodies
                if carried(j, b) in known
            ]
            found[f"strike {j.q}"] = summed(terms)
        return found

    def misplaced(self, numbers: Mapping[str, float]) -> tuple[str, str] | None:
        """A link of the next step that is not where or what the link of this one was, and that one; None if all are.

        numbers: by name, of all masses and lengths.
        """
        bodies, rng = self.chain.bodies, np.random.default_rng(0)

        def place(point: Reach, angles: np.ndarray) -> complex:
            return complex(sum(numbers[c] * np.exp(1j * angles[a]) for a, c in point.items()))

        for _ in range(SAMPLES):
            old = rng.uniform(-np.pi, np.pi, len(bodies))
            new = np.array([old[s] + np.pi * (s in self.way) for s in self.before])
            foot = place(self.way, old)
            for j in bodies:
                was = bodies[self.before[j.number]]
                same = all(
                    np.isclose(numbers[j.constant(key)], numbers[was.constant(key)], rtol=CLOSE)
                    for key in ("mass", "inertia")
                )
                if not same or abs(place(j.centre, new) + foot - place(was.centre, old)) > CLOSE * abs(foot):
                    return j.name, was.name
        return None


def carried(j: Body, b: Body) -> str:
    """The name of N_jb."""
    return f"chain_N_{j.number + 1}_{b.number + 1}"


def at_end(angle: Angle, end: str) -> Angle:
    """The angle at one end of time."""
    return Angle({f"{name}{end}": count for name, count in angle.parts.items()}, angle.turns)
