r"""What a link that slides adds to the equations of a chain; the formulas are those of `motion`.

m_s = sum_k m_k over the links k that s carries, itself too
b_as = sum_k m_k c_ka over those that both a and s carry
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from ..lean.records import dataclass
from .angles import grouped, negated, scaled_angle, summed
from .bodies import Body


@dataclass(frozen=True)
class Sliding:
    """The prismatic joints of a chain; bodies: all its links."""

    bodies: Sequence[Body]

    @property
    def links(self) -> list[Body]:
        """Those that slide."""
        return [body for body in self.bodies if body.slides]

    def constants(self) -> dict[str, str]:
        """Name -> value of each m_s, and of each b_as that is not b_a itself."""
        found = {}
        for s in self.links:
            carried = [k for k in self.bodies if on_way(s, k)]
            found[mass(s)] = summed(k.constant("mass") for k in carried)
            for a in self.bodies:
                if on_way(a, s) and a is not s:
                    found[first_moment(a, s)] = summed(
                        scaled_angle(k.constant("mass"), k.centre[a.number]) for k in carried
                    )
        return found

    def moments(self, a: Body) -> Iterator[str]:
        """What f_a has of each link that slides, N m."""
        for s in self.links:
            if on_way(a, s) or on_way(s, a):
                lag = a.phi.minus(s.phi)
                parts = [negated(scaled_angle(lag.sin, f"d{s.q}[rate]")), scaled_angle("2", lag.cos, *swept(s))]
                yield scaled_angle(first_moment(a, s), grouped(parts))

    def balance(self, s: Body, held: Sequence[str]) -> Iterator[str]:
        """The equation of a link that slides, without the forces, N. held: sin phi_s (ddy + g) + ..., term by term."""
        for b in self.bodies:
            if b.rates and (on_way(b, s) or on_way(s, b)):
                lag, spin, turn = s.phi.minus(b.phi), grouped(f"{rate}[rate]" for rate in b.rates), grouped(b.rates)
                parts = [scaled_angle(lag.sin, spin), negated(scaled_angle(lag.cos, f"{turn}**2"))]
                yield scaled_angle(first_moment(b, s), grouped(parts))
        for r in self.links:
            if on_way(r, s) or on_way(s, r):
                lag = s.phi.minus(r.phi)
                parts = [scaled_angle(lag.cos, f"d{r.q}[rate]"), scaled_angle("2", lag.sin, *swept(r))]
                yield scaled_angle(mass(r if on_way(s, r) else s), grouped(parts))
        yield from (scaled_angle(mass(s), own) for own in held)


def on_way(a: Body, k: Body) -> bool:
    """Whether link a carries link k: it is k, or on the way to it."""
    return a.number in k.centre


def mass(s: Body) -> str:
    """The name of m_s."""
    return f"chain_m_{s.number + 1}"


def first_moment(a: Body, s: Body) -> str:
    """The name of b_as: b_a where s carries all that a does."""
    return f"chain_b_{a.number + 1}" + ("" if on_way(s, a) else f"_{s.number + 1}")


def swept(s: Body) -> list[str]:
    """The factors of w_s dq_s."""
    return [grouped(s.rates), f"d{s.q}"]


def slid(s: Body, across: bool) -> list[str]:
    """A coordinate of e(phi_s) ddq_s + 2 e'(phi_s) w_s dq_s, term by term; across: that along x, else along y."""
    along, side = (s.phi.cos, negated(s.phi.sin)) if across else (s.phi.sin, s.phi.cos)
    return [scaled_angle(along, f"d{s.q}[rate]"), scaled_angle("2", side, *swept(s))]
