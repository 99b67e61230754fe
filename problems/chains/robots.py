r"""Robots that a file may name: `model: five_link_biped` is short for a chain, expressions and constraints at the ends.

The five-link biped of Kelly 2017, section 7 and appendix F: one step of a planar walker with point feet.

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

q_i is the absolute angle of link i, zero when it is upright, counter-clockwise positive. u_i is the torque of link i's
motor on it from the link that it hangs on. The paper misprints three equations: (F.4) has dq_i I_i for ddq_i I_i, the
sum on the right of (F.7) begins with link 4, as the one on the left does, and the normal vector of (7.4) is (0, 1).
Lengths, masses and inertias are those of Table 4, which measures d3 from the hip. The paper's electronic supplement
measures its 0.2 m from the top of the torso: d3 = l3 - 0.2 m = 0.425 m.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

from ..lean.records import dataclass
from ..schema.model import CHAIN, FIVE_LINK_BIPED
from ..yaml.document import Path
from ..yaml.locations import Finding
from .sections import list_in, mapping_in


@dataclass(frozen=True)
class Robot:
    """A chain with a name.

    parameters: that a file gives, name -> (unit, note).
    chain: its section `model:`.
    expressions: name -> what it is, as expressions of the chain.
    boundary: constraints at the ends of time.
    """

    parameters: Mapping[str, tuple[str, str]]
    chain: Mapping[str, Any]
    expressions: Mapping[str, str]
    boundary: tuple[Mapping[str, Any], ...]

    def lacking(self, name: str, data: Mapping[str, Any]) -> Iterator[Finding]:
        """A mistake for each parameter that the file does not give.

        name: of the robot.
        data: of the file.
        """
        given = data.get("parameters") or {}
        for own, (unit, note) in self.parameters.items():
            if isinstance(given, dict) and own not in given:
                what = f"the model {name} needs the parameter {own}, {note}"
                yield Finding(("parameters",), what, f"add {own}: under parameters:, in {unit}")


_LINKS = {
    # name: what else a link of the biped says than its mass, length, inertia and motor
    "stance_tibia": {"com": "l1 - d1"},
    "stance_femur": {"com": "l2 - d2"},
    "torso": {"com": "d3"},
    "swing_femur": {"com": "d4", "parent": "torso", "at": "0", "zero": "down"},
    "swing_tibia": {"com": "d5", "zero": "down"},
}
_FROM = ("the knee, downwards", "the hip, downwards", "the hip, upwards", "the hip, downwards", "the knee, downwards")
_OF_LINKS = {
    "m": ("kg", "mass of the {}"),
    "I": ("kg*m^2", "rotational inertia of the {}, about its centre of mass"),
    "l": ("m", "length of the {}"),
    "d": ("m", "centre of mass of the {}, from {}"),
}

_BIPED = Robot(
    parameters={
        **{
            f"{symbol}{i}": (unit, note.format(name.replace("_", " "), place))
            for symbol, (unit, note) in _OF_LINKS.items()
            for i, (name, place) in enumerate(zip(_LINKS, _FROM, strict=True), start=1)
        },
        "g": ("m/s^2", "acceleration of gravity"),
        "step_length": ("m", "distance from the stance foot to the swing foot as it lands"),
    },
    chain={
        "kind": CHAIN,
        "gravity": "g",
        "zero": "up",
        "links": [
            {"name": name, "mass": f"m{i}", "length": f"l{i}", "inertia": f"I{i}", "motor": True, **own}
            for i, (name, own) in enumerate(_LINKS.items(), start=1)
        ],
        "step": {"foot": "swing_tibia", "swap": [["stance_tibia", "swing_tibia"], ["stance_femur", "swing_femur"]]},
    },
    expressions={"foot_x": "swing_tibia_x", "foot_y": "swing_tibia_y"},
    boundary=(
        {"name": "step_length", "expression": "swing_tibia_x[final]", "equals": "step_length"},  # (7.3)
        {"name": "foot_lands", "expression": "swing_tibia_y[final]", "equals": 0},  # (7.3)
        {"name": "foot_leaves_upwards", "expression": "swing_tibia_vy[initial]", "lower": 0},  # (7.4)
        {"name": "foot_lands_downwards", "expression": "swing_tibia_vy[final]", "upper": 0},  # (7.4)
    ),
)

ROBOTS = {FIVE_LINK_BIPED: _BIPED}
"""Name -> the robot."""


def robot_of(data: Mapping[str, Any]) -> str:
    """The name of the robot that a file is of; "" if it names none, or says more of its model than a name."""
    model = data.get("model")
    name = model["kind"] if isinstance(model, dict) and model.keys() == {"kind"} else model
    return name if isinstance(name, str) and name in ROBOTS else ""


def write_chain(data: dict[str, Any], name: str) -> tuple[dict[Path, Path], list[Finding]]:
    """Write the chain of a robot in place of its name, with its expressions and constraints.

    data: of the file; it is changed.
    name: of the robot.

    Returns the path of each value that was made -> where it comes from, and the mistakes.
    """
    robot, short = ROBOTS[name], dict[Path, Path]()
    found = list(robot.lacking(name, data))
    data["model"] = deepcopy(robot.chain)
    expressions = mapping_in(data, "expressions")
    for own, value in robot.expressions.items():
        if own in expressions:
            found.append(Finding(("expressions", own), f"{own} is a name of the model {name}", "choose another name"))
            continue
        expressions[own] = {"value": value, "note": "of the swing foot"}
        short["expressions", own] = ("model",)
    boundary = list_in(mapping_in(data, "constraints"), "boundary")
    for constraint in robot.boundary if not found else ():
        short["constraints", "boundary", len(boundary)] = ("model",)
        boundary.append(dict(constraint))
    return short, found
