"""The equations of motion of a chain, derived a second time: by SymEngine, from energies and virtual work."""

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
import symengine as se

QUARTERS = {"right": 0, "up": 1, "left": 2, "down": -1}


@dataclass
class Link:
    """on: index of the link that it hangs on, -1 for the base. turn: of a joint that does not turn."""

    m: float
    l: float  # noqa: E741
    d: float
    I: float  # noqa: E741
    on: int = -1
    at: float | None = None
    zero: str = "down"
    turn: float | None = None
    torque: float = 0.0
    slides: bool = False
    force: float = 0.0

    @property
    def moves(self) -> bool:
        return self.slides or self.turn is None


@dataclass
class Robot:
    """forces: (link, distance from its joint, Fx, Fy). base: "fixed", "cart" or "floating"."""

    links: list[Link]
    base: str = "fixed"
    relative: bool = False
    g: float = 9.81
    cart: float = 0.0
    push: float = 0.0
    forces: list[tuple[int, float, float, float]] = field(default_factory=list)

    def residuals(self, q, dq, ddq) -> np.ndarray:
        """d/dt dL/dq' - dL/dq - Q of each coordinate: those of the base first, then the angles, all at one point."""
        return self.compiled(np.concatenate([q, dq, ddq]))

    @cached_property
    def compiled(self):
        return se.Lambdify([*self.z, *self.v, *self.a], self.equations)

    @property
    def z(self):
        return se.symbols(f"z:{self.coordinates}")

    @property
    def v(self):
        return se.symbols(f"v:{self.coordinates}")

    @property
    def a(self):
        return se.symbols(f"a:{self.coordinates}")

    @cached_property
    def coordinates(self) -> int:
        return sum(link.moves for link in self.links) + {"fixed": 0, "cart": 1, "floating": 2}[self.base]

    @cached_property
    def equations(self) -> list[se.Expr]:
        z, v, a = self.z, self.v, self.a
        energy, potential, work, joints, tips, angles = 0, 0, 0, [], [], []
        moving = list(z)
        base = {"fixed": (0, 0), "cart": (z[0], 0), "floating": tuple(z[:2])}[self.base]
        del moving[: {"fixed": 0, "cart": 1, "floating": 2}[self.base]]
        if self.base == "cart":
            energy += self.cart * v[0] ** 2 / 2
            work += self.push * z[0]
        speed = lambda f: sum(se.diff(f, own) * rate for own, rate in zip(z, v, strict=True))  # noqa: E731
        for link in self.links:
            before = angles[link.on] if link.on >= 0 else 0
            if link.turn is not None:
                angle = (before if link.on >= 0 else QUARTERS[link.zero] * se.pi / 2) + link.turn
            else:
                angle = moving.pop(0) + (before if self.relative and link.on >= 0 else QUARTERS[link.zero] * se.pi / 2)
                work += link.torque * (angle - before)
            origin = base
            if link.on >= 0:
                along = self.links[link.on].l if link.at is None else link.at
                origin = tuple(
                    p + along * e for p, e in zip(joints[link.on], (se.cos(before), se.sin(before)), strict=True)
                )
            if link.slides:
                slid = moving.pop(0)
                work += link.force * slid
                origin = tuple(p + slid * e for p, e in zip(origin, (se.cos(angle), se.sin(angle)), strict=True))
            joints.append(origin)
            angles.append(angle)
            x, y = (p + link.d * e for p, e in zip(origin, (se.cos(angle), se.sin(angle)), strict=True))
            tips.append(tuple(p + link.l * e for p, e in zip(origin, (se.cos(angle), se.sin(angle)), strict=True)))
            energy += link.m * (speed(x) ** 2 + speed(y) ** 2) / 2 + link.I * speed(angle) ** 2 / 2
            potential += link.m * self.g * y
        for number, distance, fx, fy in self.forces:
            x, y = (
                p + distance * e
                for p, e in zip(joints[number], (se.cos(angles[number]), se.sin(angles[number])), strict=True)
            )
            work += fx * x + fy * y
        self.tips = tips
        momenta = [se.diff(energy, rate) for rate in v]
        found = []
        for own, p in zip(z, momenta, strict=True):
            change = sum(se.diff(p, c) * r + se.diff(p, r) * s for c, r, s in zip(z, v, a, strict=True))
            found.append(change - se.diff(energy - potential, own) - se.diff(work, own))
        return found
