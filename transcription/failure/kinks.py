"""Norms that vanish along a solution: at zero they have a kink, which stops an engine that trusts second derivatives.

The least fuel, an integral of a norm of a thrust, has arcs on which the thrust is off. `norm` and `hypot` are smooth
over 1e-9 there, and sqrt(u**2 + v**2) not at all: the curvature is 1e9 at zero and nothing beside it.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from ...problems.expressions.expression import Expression
from ...problems.expressions.tree import Operation, nodes
from ...problems.problem import Phase
from ...problems.text import shorten
from ..solution.trajectory import Trajectory
from ..solution.violation import when_between

NORMS = ("norm", "hypot")
NOTHING = 1e-3
"""Of its largest value along the trajectory: a norm below that is all but zero."""

SMOOTH = "1e-6"


def vanishing_norm(trajectory: Trajectory) -> str:
    """Which norm in what holds over time is all but zero at collocation points, when, and the remedy; "" for none."""
    phase, k = trajectory.phase, trajectory.mesh.collocated
    values = trajectory.at_collocated
    for text, own, smooth in _norms(phase):
        with np.errstate(all="ignore"):
            size = np.abs(np.broadcast_to(own(values, np), k.shape))
        small = np.flatnonzero(size <= NOTHING * size.max())
        if len(small):
            when = when_between(*trajectory.times[k][small[[0, -1]]].tolist())
            return f'"{shorten(text)}" is all but zero{when}, and has a kink at zero: {smooth}'
    return ""


def _smoother(norm: Operation, text: str) -> str:
    """The remedy for a kink; norm, text: the operation, and what it stands in."""
    operands = [text[own.start : own.stop] for own in norm.operands]
    inside = operands[0] if norm.symbol == "sqrt" else " + ".join(map(_square, operands))
    smooth = f"sqrt({shorten(inside)} + {SMOOTH})"
    return f"write {smooth}, smooth over 1e-3 of its unit, and go on from there with less (--guess)"


def _square(operand: str) -> str:
    return f"{operand}**2" if operand.isidentifier() else f"({operand})**2"


def _is_norm(node: Operation) -> bool:
    """Whether it is a root of squares, by its name or written out."""
    squared = (isinstance(own, Operation) and own.symbol == "**" for own in nodes(node))
    return node.symbol in NORMS or (node.symbol == "sqrt" and any(squared))


def _norms(phase: Phase) -> Iterator[tuple[str, Expression, str]]:
    """Each norm in the functions of a phase over time and in what they need: its text, itself, and the remedy."""
    for function in (own for own in phase.over_time if isinstance(own, Expression)):
        for part in function.parts:
            for node in part.nodes:
                if isinstance(node, Operation) and _is_norm(node):
                    own = replace(function, text=part.text, root=node)
                    yield part.text[node.start : node.stop], own, _smoother(node, part.text)
