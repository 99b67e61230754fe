r"""The five-link biped of Kelly 2017, section 7 and appendix F: one step of a planar walker with point feet.

                    P3                    link                 from - to    centre of mass, at distance d
                   /                      1  stance tibia      P0 - P1      d1 below P1, the knee
                  / 3                     2  stance femur      P1 - P2      d2 below P2, the hip
                 /                        3  torso             P2 - P3      d3 above P2, the hip
               P2                         4  swing femur       P2 - P4      d4 below P2, the hip
           2  /  \  4                     5  swing tibia       P4 - P5      d5 below P4, the knee
             /    \
           P1      P4                     P0 is the stance foot, at rest at the origin; P5 is the swing foot.
        1  /        \  5                  The walker moves along +x; y points up.
          /          \
        P0            P5

q_i (rad) is the absolute angle of link i, zero when it is upright, counter-clockwise positive: a walker that leans
forward has negative angles. With e(q) = (-sin q, cos q) every point is a sum of multiples of the e(q_i): P1 = l1 e(q1),
P2 = P1 + l2 e(q2), P3 = P2 + l3 e(q3), P4 = P2 - l4 e(q4), P5 = P4 - l5 e(q5). The multiples are called its reach.

u_i (N m) is the torque of link i's motor, counter-clockwise positive on link i and what it carries: u1 at the stance
ankle, u2 at the stance knee, u3 and u4 at the hip (on the torso from the stance femur, on the swing femur from the
torso), u5 at the swing knee. The ankle of the paper has no motor: its problem bounds u1 to zero.

Dynamics: the angular accelerations ddq_i = d2 q_i/dt2 are algebraic variables, which the angular momentum balances
(F.4)-(F.8) determine. The paper misprints two of them: (F.4) has dq_i I_i for ddq_i I_i, and the sum on the right of
(F.7) begins with link 4, as the one on the left does.

Boundary: the state at the final time, just before the swing foot strikes, becomes the initial state of the same
step taken by the other leg. (F.9) swaps the legs; (F.11)-(F.15) conserve angular momentum about the point of collision
and about the joints. The paper's f_H maps the final state to the initial one; here both are tied by the equations as
they stand. Further the swing foot ends at (step_length, 0), (7.3), leaves the ground upwards and lands downwards,
(7.4), whose normal vector is (0, 1), not (1, 0) as printed; like every constraint it holds with equality too.

Lengths, masses and inertias are those of Table 4, which measures d3 from the hip. The paper's electronic supplement
measures its 0.2 m from the top of the torso: d3 = l3 - 0.2 m = 0.425 m is the supplement's walker.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cached_property, partial
from math import inf
from typing import Any, NamedTuple

import numpy as np

from ..lean.records import dataclass
from ..quantities import Numeric, Range
from .model import Equations, Model, Quantity

LINKS = (1, 2, 3, 4, 5)
ZERO = Range(0.0, 0.0)
INITIAL, FINAL = "[initial]", "[final]"

BALANCES = {
    # name of the joint: number of its torque, pivot, the links that it carries
    "stance_ankle": (1, 0, LINKS),  # (F.4)
    "stance_knee": (2, 1, (2, 3, 4, 5)),  # (F.5)
    "stance_hip": (3, 2, (3, 4, 5)),  # (F.6)
    "swing_hip": (4, 2, (4, 5)),  # (F.7)
    "swing_knee": (5, 4, (5,)),  # (F.8)
}

STRIKES = {
    # name of the joint after the collision: pivot and links before it, and the same ones by their numbers after it
    "stance_ankle": ((5, LINKS), (0, LINKS)),  # (F.11)
    "stance_knee": ((4, (1, 2, 3, 4)), (1, (2, 3, 4, 5))),  # (F.12)
    "stance_hip": ((2, (1, 2, 3)), (2, (3, 4, 5))),  # (F.13)
    "swing_hip": ((2, (1, 2)), (2, (4, 5))),  # (F.14)
    "swing_knee": ((1, (1,)), (4, (5,))),  # (F.15)
}

Carried = tuple[int, tuple[int, ...]]
"""A pivot and the links whose momentum about it is conserved."""

Reach = tuple[float, ...]
"""(c_1, ..., c_5) in m: the point sum_i c_i e(q_i)."""


class Vector(NamedTuple):
    """A vector in the plane; x and y are numbers, arrays or expressions."""

    x: Numeric
    y: Numeric


def cross(a: Vector, b: Vector) -> Numeric:
    """The component of a x b that points out of the plane."""
    return a.x * b.y - a.y * b.x


def combine(reach: Sequence[float], vectors: Sequence[Vector]) -> Vector:
    """sum_i reach_i vectors_i: a point of the walker, its velocity or its acceleration."""
    terms = [(c, vector) for c, vector in zip(reach, vectors, strict=True) if c]
    return Vector(sum(c * v.x for c, v in terms), sum(c * v.y for c, v in terms))


@dataclass(frozen=True)
class Motion:
    """The walker at one time, or at one end: e(q_i) of the links 1 to 5, and their derivatives by time.

    values, functions: as functions of a problem are called with. end: "[initial]" or "[final]" at the boundary, where
    there are no accelerations.
    """

    values: Mapping[str, Numeric]
    functions: Any
    end: str = ""

    def row(self, name: str) -> list[Numeric]:
        """A quantity of each link, such as "dq"."""
        return [self.values[f"{name}{i}{self.end}"] for i in LINKS]

    @cached_property
    def e(self) -> list[Vector]:
        return [Vector(-self.functions.sin(q), self.functions.cos(q)) for q in self.row("q")]

    @cached_property
    def de(self) -> list[Vector]:
        """(F.1): the derivative of e by its angle is e turned by a right angle, (-e.y, e.x)."""
        return [Vector(-e.y * w, e.x * w) for e, w in zip(self.e, self.row("dq"), strict=True)]

    @cached_property
    def dde(self) -> list[Vector]:
        """(F.2)."""
        links = zip(self.e, self.row("dq"), self.row("ddq"), strict=True)
        return [Vector(-e.y * a - e.x * w**2, e.x * a - e.y * w**2) for e, w, a in links]


@dataclass(frozen=True)
class Walker:
    """Masses m (kg) and moments of inertia I (kg m^2, about the centre of mass) of links 1 to 5, g (m/s^2).

    P: reaches of P0 to P5. G: reaches of the centres of mass of links 1 to 5.
    """

    m: Sequence[float]
    I: Sequence[float]  # noqa: E741
    g: float
    P: Sequence[Reach]
    G: Sequence[Reach]

    @classmethod
    def of(cls, parameters: Mapping[str, float]) -> Walker:
        """From the parameters of the model by name, SI units."""
        m, inertia, l, d = ([parameters[f"{name}{i}"] for i in LINKS] for name in "mIld")  # noqa: E741
        P = (
            (0.0, 0.0, 0.0, 0.0, 0.0),
            (l[0], 0.0, 0.0, 0.0, 0.0),
            (l[0], l[1], 0.0, 0.0, 0.0),
            (l[0], l[1], l[2], 0.0, 0.0),
            (l[0], l[1], 0.0, -l[3], 0.0),
            (l[0], l[1], 0.0, -l[3], -l[4]),
        )
        G = (
            (l[0] - d[0], 0.0, 0.0, 0.0, 0.0),
            (l[0], l[1] - d[1], 0.0, 0.0, 0.0),
            (l[0], l[1], d[2], 0.0, 0.0),
            (l[0], l[1], 0.0, -d[3], 0.0),
            (l[0], l[1], 0.0, -l[3], -d[4]),
        )
        return cls(m, inertia, parameters["g"], P, G)

    def lever(self, e: Sequence[Vector], i: int, pivot: int) -> Vector:
        """G_i - P_pivot, m.

        e: unit vectors of the links 1 to 5.
        i: number of the link, from 1.
        pivot: number of the point, from 0.
        """
        return combine([g - p for g, p in zip(self.G[i - 1], self.P[pivot], strict=True)], e)

    def balance(
        self, torque: int, pivot: int, links: Sequence[int], values: Mapping[str, Numeric], functions: Any
    ) -> Numeric:
        """Torque + moment of the weights - rate of change of the angular momentum, N m: zero by (F.4)-(F.8).

        torque: number of the motor, from 1.
        pivot: number of the point about which moments are taken, from 0.
        links: numbers of the links that the joint carries.
        values, functions: as functions of a problem are called with (`problems.problem.Function`).
        """
        motion = Motion(values, functions)
        e, dde, ddq = motion.e, motion.dde, motion.row("ddq")
        moments = []
        for i in links:
            acceleration = combine(self.G[i - 1], dde)
            effect = Vector(-acceleration.x, -self.g - acceleration.y)  # of weight and inertia, for a mass of 1
            moments.append(self.m[i - 1] * cross(self.lever(e, i, pivot), effect) - self.I[i - 1] * ddq[i - 1])
        return values[f"u{torque}"] + sum(moments)

    def momentum(self, motion: Motion, pivot: int, links: Sequence[int]) -> Numeric:
        """Angular momentum of the links about the pivot, kg m^2/s: either side of (F.11)-(F.15).

        motion: angles and rates of all links.
        pivot: number of the point, from 0.
        links: numbers of the links, from 1.
        """
        e, de, dq = motion.e, motion.de, motion.row("dq")
        return sum(
            self.m[i - 1] * cross(self.lever(e, i, pivot), combine(self.G[i - 1], de)) + self.I[i - 1] * dq[i - 1]
            for i in links
        )

    def strike(self, before: Carried, after: Carried, values: Mapping[str, Numeric], functions: Any) -> Numeric:
        """Angular momentum before the collision - after it, kg m^2/s: zero by (F.11)-(F.15).

        before: pivot and links at the final time of the step.
        after: the same ones by their numbers at its initial time.
        values, functions: as functions of a problem are called with, names at both ends of time.
        """
        old, new = (Motion(values, functions, end) for end in (FINAL, INITIAL))
        return self.momentum(old, *before) - self.momentum(new, *after)

    def foot(self, axis: str, end: str, values: Mapping[str, Numeric], functions: Any) -> Numeric:
        """One coordinate of P5, m.

        axis: "x" or "y".
        end: "[initial]", "[final]", or "" at any time.
        values, functions: as functions of a problem are called with.
        """
        return getattr(combine(self.P[5], Motion(values, functions, end).e), axis)

    def foot_velocity(self, axis: str, end: str, values: Mapping[str, Numeric], functions: Any) -> Numeric:
        """One coordinate of the velocity of P5, m/s; arguments as of `foot`."""
        return getattr(combine(self.P[5], Motion(values, functions, end).de), axis)


def equations(parameters: Mapping[str, float]) -> Equations:
    """The equations of the walker with these parameters (SI units, by name)."""
    walker, step = Walker.of(parameters), parameters["step_length"]
    swap = {f"swap_q{i}": (partial(_difference, f"q{i}{INITIAL}", f"q{6 - i}{FINAL}"), ZERO) for i in LINKS}  # (F.9)
    strikes = {f"heel_strike_{name}": (partial(walker.strike, *row), ZERO) for name, row in STRIKES.items()}
    return Equations(
        rates={f"{name}{i}": partial(_value, f"d{name}{i}") for name in ("q", "dq") for i in LINKS},
        residuals={f"balance_{name}": partial(walker.balance, *row) for name, row in BALANCES.items()},
        boundary={
            **swap,
            **strikes,
            "step_length": (partial(walker.foot, "x", FINAL), Range(step, step)),  # (7.3)
            "foot_lands": (partial(walker.foot, "y", FINAL), ZERO),  # (7.3)
            "foot_leaves_upwards": (partial(walker.foot_velocity, "y", INITIAL), Range(0.0, inf)),  # (7.4)
            "foot_lands_downwards": (partial(walker.foot_velocity, "y", FINAL), Range(-inf, 0.0)),  # (7.4)
        },
        outputs={"foot_x": partial(walker.foot, "x", ""), "foot_y": partial(walker.foot, "y", "")},
    )


def _value(name: str, values: Mapping[str, Numeric], functions: Any) -> Numeric:
    return values[name]


def _difference(name: str, other: str, values: Mapping[str, Numeric], functions: Any) -> Numeric:
    return values[name] - values[other]


def pose(values: Mapping[str, float], parameters: Mapping[str, float]) -> dict[str, np.ndarray]:
    """The joints of both legs and of the torso in m, for the angles q1 to q5 of one time."""
    walker, e = Walker.of(parameters), Motion(values, np).e
    parts = {"stance leg": (0, 1, 2), "torso": (2, 3), "swing leg": (2, 4, 5)}
    return {part: np.array([combine(walker.P[j], e) for j in joints], float) for part, joints in parts.items()}


_NAMES = ("stance tibia", "stance femur", "torso", "swing femur", "swing tibia")
_JOINTS = [name.replace("_", " ") for name in BALANCES]
_FROM = ("the knee, downwards", "the hip, downwards", "the hip, upwards", "the hip, downwards", "the knee, downwards")


def _of_links(symbol: str, unit: str, notes: Sequence[str]) -> dict[str, Quantity]:
    return {f"{symbol}{i}": Quantity(unit, note) for i, note in zip(LINKS, notes, strict=True)}


MODEL = Model(
    name="five_link_biped",
    source="Kelly 2017, section 7, Table 4 and appendix F",
    parameters={
        **_of_links("m", "kg", [f"mass of the {name}" for name in _NAMES]),
        **_of_links("I", "kg*m^2", [f"rotational inertia of the {name}, about its centre of mass" for name in _NAMES]),
        **_of_links("l", "m", [f"length of the {name}" for name in _NAMES]),
        **_of_links("d", "m", [f"centre of mass of the {a}, from {b}" for a, b in zip(_NAMES, _FROM, strict=True)]),
        "g": Quantity("m/s^2", "acceleration of gravity"),
        "step_length": Quantity("m", "distance from the stance foot to the swing foot as it lands"),
    },
    states={
        **_of_links("q", "rad", [f"angle of the {name}, 0 upright, counter-clockwise positive" for name in _NAMES]),
        **_of_links("dq", "rad/s", [f"angular rate of the {name}" for name in _NAMES]),
    },
    controls=_of_links("u", "N*m", [f"torque of the {name}" for name in _JOINTS]),
    algebraic=_of_links("ddq", "rad/s^2", [f"angular acceleration of the {name}" for name in _NAMES]),
    build=equations,
    pose=pose,
)
