r"""The equations of motion of a chain, by Lagrange; M(q) ddq + C(q, dq) = B u, left as residuals.

With G_k = base + sum_a c_ka e(phi_a) (see `bodies`) and the constants

    M_ab = sum_k m_k c_ka c_kb, plus the inertia I_a where a = b
    b_a = sum_k m_k c_ka        m = sum_k m_k, and the mass of the cart

the kinetic energy is sum_ab M_ab cos(phi_a - phi_b) w_a w_b / 2 + sum_a b_a w_a e'(phi_a) . v + m v^2/2, where w_a is
the rate of phi_a and v the velocity of the base, and the potential energy is g (m y + sum_a b_a sin phi_a). So
the balance of moments of link a is

    f_a = sum_b M_ab (cos(phi_a - phi_b) dw_b + sin(phi_a - phi_b) w_b^2) + b_a (cos phi_a (ddy + g) - sin phi_a ddx)

and the equation of the angle q_i: the sum of f_a over the links that turn with q_i is the torque of its motors, and of
forces from outside. The base moves as

    m ddx + sum_a b_a (-sin phi_a dw_a - cos phi_a w_a^2) = F_x
    m (ddy + g) + sum_a b_a (cos phi_a dw_a - sin phi_a w_a^2) = F_y

For the five-link biped of Kelly 2017 these are sums and differences of (F.4)-(F.8).

A link s that slides by q_s has it in its distances c_ks, so that M_ab and b_a vary with it. Each link that s carries
has the acceleration e(phi_s) ddq_s + 2 e'(phi_s) w_s dq_s besides. With m_s the mass that s carries, itself too, and
b_as = sum_k m_k c_ka over what both a and s carry, this adds

    b_as (-sin(phi_a - phi_s) ddq_s + 2 cos(phi_a - phi_s) w_s dq_s)                      to f_a
    m_s (cos phi_s ddq_s - 2 sin phi_s w_s dq_s), m_s (sin phi_s ddq_s + 2 cos phi_s w_s dq_s)   to those of the base

and the equation of q_s is that the force along the joint is, with m_sr the mass that s and r both carry,

    sum_b b_bs (sin(phi_s - phi_b) dw_b - cos(phi_s - phi_b) w_b^2) + m_s (cos phi_s ddx + sin phi_s (ddy + g))
        + sum_r m_sr (cos(phi_s - phi_r) ddq_r + 2 sin(phi_s - phi_r) w_r dq_r)
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cached_property

from ..lean.records import dataclass
from ..schema.model import CART, FIXED, FLOATING, ForceEntry, ModelEntry
from .angles import Angle, grouped, negated, scaled_angle, summed
from .bodies import Body, Reach, bodies, control_of
from .sliding import Sliding, first_moment, mass, slid

CART_NAME = "cart"
GRAVITY = "chain_gravity"
TOTAL = "chain_mass"
ACROSS, UP = "x", "y"
"""The states of a base that moves."""
ALL: Mapping[int, str] = {}
"""The shares of a point that all links on the way to it carry whole."""


@dataclass(frozen=True)
class Chain:
    """The equations of one chain as texts; entry: without mistakes."""

    entry: ModelEntry

    @cached_property
    def bodies(self) -> list[Body]:
        return bodies(self.entry)

    @cached_property
    def sliding(self) -> Sliding:
        return Sliding(self.bodies)

    @property
    def base(self) -> list[str]:
        """The states that the base moves by."""
        return {FIXED: [], CART: [ACROSS], FLOATING: [ACROSS, UP]}[self.entry.base]

    @property
    def coordinates(self) -> list[str]:
        """All states that are not velocities; the velocity of q is dq."""
        return [*self.base, *(body.q for body in self.bodies if body.q)]

    def reach(self, a: Body) -> Iterator[tuple[Body, str]]:
        """(k, c_ka) for every link k that a carries, itself first."""
        return ((k, k.centre[a.number]) for k in self.bodies if a.number in k.centre)

    def constants(self) -> dict[str, str]:
        """Name -> value of all that is made of masses and lengths: M_ab for a <= b, b_a, m, and what sliding adds."""
        found = self.sliding.constants()
        for a in self.bodies:
            for b in self.bodies[a.number :]:
                shared = [
                    scaled_angle(k.constant("mass"), c, k.centre[b.number])
                    for k, c in self.reach(a)
                    if b.number in k.centre
                ]
                if a is b:
                    shared.append(a.constant("inertia"))
                if shared:
                    found[self.mass(a, b)] = summed(shared)
            found[first_moment(a, a)] = summed(scaled_angle(k.constant("mass"), c) for k, c in self.reach(a))
        cart = [f"{CART_NAME}_mass"] if self.entry.base == CART else []
        found[TOTAL] = summed([*cart, *(body.constant("mass") for body in self.bodies)])
        return found

    @staticmethod
    def mass(a: Body, b: Body) -> str:
        """The name of M_ab."""
        first, last = sorted((a.number + 1, b.number + 1))
        return f"chain_M_{first}_{last}"

    def number_of(self, name: str) -> int:
        """The number of a link."""
        return next(body.number for body in self.bodies if body.name == name)

    def coupled(self, a: Body, b: Body) -> bool:
        """Whether M_ab is not zero: one link is on the way to the other."""
        return any(b.number in k.centre for k, _ in self.reach(a))

    def moments(self, a: Body) -> str:
        """f_a, N m."""
        terms = []
        for b in self.bodies:
            if not b.rates or not self.coupled(a, b):
                continue
            lag = a.phi.minus(b.phi)
            spin, turn = grouped(f"{rate}[rate]" for rate in b.rates), grouped(b.rates)
            parts = [scaled_angle(lag.cos, spin), scaled_angle(lag.sin, f"{turn}**2")]
            terms.append(scaled_angle(self.mass(a, b), grouped(parts)))
        terms += self.sliding.moments(a)
        return summed([*terms, *(scaled_angle(first_moment(a, a), own) for own in self.held(a.phi))])

    def held(self, phi: Angle) -> Iterator[str]:
        """cos phi (ddy + g) - sin phi ddx, term by term."""
        up = [f"d{UP}[rate]"] if UP in self.base else []
        weight = [GRAVITY] if self.entry.gravity.text != "0" else []
        yield scaled_angle(phi.cos, grouped([*up, *weight])) if up or weight else ""
        yield negated(scaled_angle(phi.sin, f"d{ACROSS}[rate]")) if self.base else ""

    def equations(self) -> dict[str, str]:
        """Name -> residual of each coordinate, in the order of `coordinates`."""
        found = {f"motion {axis}": self.of_base(axis) for axis in self.base}
        for body in (body for body in self.bodies if body.q):
            found[f"motion {body.q}"] = self.along(body) if body.slides else self.about(body.q)
        return found

    def about(self, q: str) -> str:
        """The sum of f_a over the links that turn with an angle, minus the torque, N m."""
        turned = [body for body in self.bodies if q in body.turning]
        moments = [self.moments(a) for a in turned] if len(turned) == 1 else [moment_of(a) for a in turned]
        return summed([*moments, *(negated(own) for own in self.torques(q))])

    def along(self, s: Body) -> str:
        """The balance of a link that slides, minus the force, N."""
        held = self.held(Angle(s.phi.parts, s.phi.turns - 1))  # e is e' of a right angle less
        return summed([*self.sliding.balance(s, list(held)), *(negated(own) for own in self.pushes(s))])

    @property
    def named_moments(self) -> dict[str, str]:
        """Name -> f_a of the links that several turn with, or that turn with several angles."""
        several = {q for body in self.bodies for q in body.turning if sum(q in b.turning for b in self.bodies) > 1}
        return {moment_of(a): self.moments(a) for a in self.bodies if several & {*a.turning}}

    def torques(self, q: str) -> Iterator[str]:
        """What acts on the angle q: motors, torques, moments of forces."""
        for body, number in zip(self.bodies, self.numbers, strict=True):
            before = self.bodies[body.before].turning if body.before is not None else ()
            acting = (q in body.turning) - (q in before)
            own = [control_of(body.link.motor, number), body.constant("torque") if body.link.torque else ""]
            yield from (scaled_angle(str(acting), one) for one in own if acting and one)
        for number, force in enumerate(self.entry.forces):
            for a, c in self.pushed(force, number).items():
                body = self.bodies[a]
                if q in body.turning:
                    across, up = force_names(force, number)
                    yield scaled_angle(
                        c, grouped([negated(scaled_angle(body.phi.sin, across)), scaled_angle(body.phi.cos, up)])
                    )

    def pushes(self, s: Body) -> Iterator[str]:
        """What acts along a link that slides: its motor, its force, those from outside."""
        yield control_of(s.link.motor, self.numbers[s.number])
        yield s.constant("force") if s.link.force else ""
        for number, force in enumerate(self.entry.forces):
            if s.number in self.pushed(force, number):
                across, up = force_names(force, number)
                yield from (scaled_angle(s.phi.cos, across), scaled_angle(s.phi.sin, up))

    @property
    def numbers(self) -> list[int]:
        """The number of each link's angle or distance, from 1."""
        count, found = 0, []
        for body in self.bodies:
            count += bool(body.q)
            found.append(count)
        return found

    def pushed(self, force: ForceEntry, number: int) -> Reach:
        """The point that a force acts on."""
        body = self.bodies[self.number_of(force.link)]
        return body.along(f"force{number + 1}_at" if force.at else body.constant("length"))

    def of_base(self, axis: str) -> str:
        """m ddx + ... - F_x, or the same of y, N."""
        along = 0 if axis == ACROSS else 1
        weight = [GRAVITY] if axis == UP and self.entry.gravity.text != "0" else []
        terms = [scaled_angle(TOTAL, grouped([f"d{axis}[rate]", *weight]))]
        terms += [scaled_angle(first_moment(a, a), grouped(self.accelerated(a, axis))) for a in self.bodies if a.rates]
        terms += [scaled_angle(mass(s), grouped(slid(s, axis == ACROSS))) for s in self.sliding.links]
        if self.entry.cart and axis == ACROSS:
            own = [control_of(self.entry.cart.motor, 0), f"{CART_NAME}_force" if self.entry.cart.force else ""]
            terms += [negated(one) for one in own if one]
        return summed(
            [*terms, *(scaled_angle("-1", force_names(own, n)[along]) for n, own in enumerate(self.entry.forces))]
        )

    @staticmethod
    def accelerated(a: Body, axis: str) -> list[str]:
        """A coordinate of d2 e(phi_a)/dt2, term by term."""
        spin, turn = grouped(f"{rate}[rate]" for rate in a.rates), grouped(a.rates)
        side, back = (negated(a.phi.sin), a.phi.cos) if axis == ACROSS else (a.phi.cos, a.phi.sin)
        return [scaled_angle(side, spin), negated(scaled_angle(back, f"{turn}**2"))]

    # -- points ---

    def position(self, point: Reach, axis: str) -> str:
        """A coordinate of a point, m."""
        directions = {a: self.bodies[a].phi for a in point}
        own = [
            scaled_angle(c, phi.cos if axis == ACROSS else phi.sin)
            for (a, c), phi in zip(point.items(), directions.values(), strict=True)
        ]
        return summed([*([axis] if axis in self.base else []), *own])

    def velocity(self, point: Reach, axis: str, share: Mapping[int, str] = ALL) -> str:
        """A coordinate of the velocity of a point, m/s, as a text.

        point: number of each link -> how far along it the point is reached, m.
        axis: ACROSS or UP.
        share: number of a link that slides -> what of the point it carries.
        """
        terms = [f"d{axis}"] if axis in self.base else []
        for a, c in point.items():
            body = self.bodies[a]
            across, up = body.phi.cos, body.phi.sin
            along, side = (across, negated(up)) if axis == ACROSS else (up, across)
            terms.append(scaled_angle(c, side, grouped(body.rates)))
            terms.append(scaled_angle(share.get(a, "1"), along, f"d{body.q}") if body.slides else "")
        return summed(terms)

    def acceleration(self, point: Reach, axis: str, share: Mapping[int, str] = ALL) -> str:
        """A coordinate of the acceleration of a point, m/s^2, as a text.

        point, axis, share: as of `velocity`.
        """
        terms = [f"d{axis}[rate]"] if axis in self.base else []
        for a, c in point.items():
            body = self.bodies[a]
            terms.append(scaled_angle(c, grouped(self.accelerated(body, axis))) if body.rates else "")
            terms.append(scaled_angle(share.get(a, "1"), grouped(slid(body, axis == ACROSS))) if body.slides else "")
        return summed(terms)

    @property
    def centre(self) -> tuple[Reach, dict[int, str]]:
        """The centre of mass of all, and what of it each link that slides carries."""
        point = {a.number: f"{first_moment(a, a)}/{TOTAL}" for a in self.bodies}
        return point, {s.number: f"{mass(s)}/{TOTAL}" for s in self.sliding.links}


def moment_of(a: Body) -> str:
    """The name of f_a."""
    return a.constant("moment")


def force_names(force: ForceEntry, number: int) -> tuple[str, str]:
    """The names of the parts of a force along x and y, "0" for one that is not there; number: from 0."""
    along, up = (f"force{number + 1}_{axis}" if getattr(force, axis).text != "0" else "0" for axis in (ACROSS, UP))
    return along, up
