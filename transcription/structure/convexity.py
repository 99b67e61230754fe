"""What kind of program a nonlinear program is: linear, quadratic, convex. Of a convex one every optimum is global."""

from __future__ import annotations

from enum import Enum
from typing import Any

import numpy as np

from ..engines.linear import hessian_of, jacobian_of
from ..program.compiled import CompiledNLP

LARGEST_BLOCK = 1000
"""Unknowns that second derivatives couple: the eigenvalues of a larger block are not computed."""

LARGEST_PROGRAM = 400
"""Unknowns of a program whose curvature is also looked at along its equations alone."""

ROUNDING = 1e-9
"""Of the largest second derivative: an eigenvalue above minus this is none below zero."""


class ProgramKind(Enum):
    """What is known of a program, and in words; with {} for where an optimum is one."""

    LINEAR = "linear program: the optimum{} is global"
    CONVEX = "convex quadratic program: the optimum{} is global"
    QUADRATIC = "quadratic program"
    NOT_CONVEX = "quadratic program, not convex: there may be other optima"
    NONLINEAR = ""

    @property
    def has_one_optimum(self) -> bool:
        return self in (ProgramKind.LINEAR, ProgramKind.CONVEX)

    def told(self, continuous: bool) -> str:
        """In words; "" for a nonlinear one.

        continuous: whether the program approximates a problem in continuous time, so that it speaks of its mesh only.
        """
        return self.value.format(" on this mesh" if continuous else "")


def kind_of_program(nlp: Any, z: np.ndarray) -> ProgramKind:
    """What a program is.

    nlp: compiled from templates; of others nothing is known, as of nonlinear ones.
    z: (n,) any point.
    """
    if not isinstance(nlp, CompiledNLP):
        return ProgramKind.NONLINEAR
    constraints, objective = nlp.degrees
    if constraints > 1 or objective > 2:
        return ProgramKind.NONLINEAR
    if objective < 2:
        return ProgramKind.LINEAR
    convex = _convex(nlp, z)
    if convex is None:
        return ProgramKind.QUADRATIC
    return ProgramKind.CONVEX if convex else ProgramKind.NOT_CONVEX


def _convex(nlp: CompiledNLP, z: np.ndarray) -> bool | None:
    """Whether the objective is convex, or at least along the linear equations; None if that is not known."""
    rows, columns = nlp.hessianstructure()
    values = nlp.hessian(z, np.zeros(nlp.m), 1.0)
    lowest = ROUNDING * float(np.abs(values).max(initial=0.0))
    sizes, own = _blocks(rows, columns, values, nlp.n)
    if sizes <= LARGEST_BLOCK and all(np.linalg.eigvalsh(block)[0] >= -lowest for block in own):
        return True
    if nlp.n > LARGEST_PROGRAM:
        return None
    H, A = hessian_of(nlp, z, np.zeros(nlp.m)).toarray(), jacobian_of(nlp, z).toarray()
    _, size, directions = np.linalg.svd(A[nlp.cl == nlp.cu])
    free = directions[np.count_nonzero(size > ROUNDING * size.max(initial=0.0)) :]
    return bool(np.linalg.eigvalsh(free @ H @ free.T).min(initial=0.0) >= -lowest)


def _blocks(rows: np.ndarray, columns: np.ndarray, values: np.ndarray, n: int) -> tuple[int, list[np.ndarray]]:
    """The largest size, and the matrices, of the blocks of unknowns that second derivatives couple."""
    label = np.arange(n)
    while True:
        before = label.copy()
        lower = np.minimum(label[rows], label[columns])
        np.minimum.at(label, rows, lower)
        np.minimum.at(label, columns, lower)
        label = label[label]
        if np.array_equal(label, before):
            break
    kinds, place = np.unique(label[rows], return_inverse=True)
    found, largest = [], 0
    for number in range(len(kinds)):
        here = np.flatnonzero(place == number)
        members, both = np.unique(np.concatenate([rows[here], columns[here]]), return_inverse=True)
        largest = max(largest, len(members))
        if len(members) > LARGEST_BLOCK:
            break
        block = np.zeros((len(members), len(members)))
        i, j = both[: len(here)], both[len(here) :]
        np.add.at(block, (i, j), values[here])
        found.append(block + np.tril(block, -1).T)
    return largest, found
