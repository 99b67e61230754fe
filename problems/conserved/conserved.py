r"""What dynamics keep: functions of states that stay what they are, whatever x, u, t and p.

A function g, linear or quadratic in states, with dg/dt = sum_i dg/dx_i f_i = 0 at all samples: the norm of a
quaternion, the sum of compartments, the products of the columns of a rotation. Such g are the null space of the matrix
of  d(basis function)/dt  at samples. Where initial and final values of all its states are given, one of the final ones
is too many; or the final values cannot be reached.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from itertools import combinations_with_replacement

import numpy as np

from ..lean.records import dataclass
from ..probe import names_asked
from ..quantities import Function

MOST = 12
"""States whose products are looked at; of more, the sums only."""

ROUNDING, RANK = 1e-10, 1e-8
"""What is less is zero: of the largest singular value, and of the length of a gradient."""

SAME = 1e-6
"""Of the sizes of its terms: what a kept function may differ by at both ends and count as the same."""


@dataclass(frozen=True)
class Contradicted:
    """A kept function, in words, whose values at both ends differ, and the last state in it."""

    function: str
    state: str
    initial: float
    final: float


@dataclass(frozen=True)
class Conserved:
    """What given final values say twice, or against each other.

    following: states whose final value follows from those of others.
    contradicted: where they contradict what the dynamics keep; None where they do not.
    """

    following: list[str]
    contradicted: Contradicted | None = None


def conserved(
    names: Sequence[str], rates: Sequence[Function], first: Sequence[float], last: Sequence[float]
) -> Conserved | None:
    """What the dynamics keep of states whose values are given at both ends; None where they keep nothing.

    names, rates: of these states.
    first, last: their values at the initial and at the final time.
    """
    found = {name: names_asked(rate) for name, rate in zip(names, rates, strict=True)} if len(names) > 1 else {}
    tied = _tied(found)
    chosen = [i for i, name in enumerate(names) if name in tied]
    if not chosen:
        return None
    names, rates = [names[i] for i in chosen], [rates[i] for i in chosen]
    first, last = [first[i] for i in chosen], [last[i] for i in chosen]
    pairs = list(combinations_with_replacement(range(len(names)), 2)) if len(names) <= MOST else []
    samples = 2 * (len(names) + len(pairs))
    asked = sorted(set(names).union(*(found[name] for name in names)))
    values = dict(zip(asked, spread(len(asked), samples), strict=True))
    sizes = np.maximum(np.abs(first), np.abs(last))
    values |= {name: values[name] * size for name, size in zip(names, sizes, strict=True) if size > 0}
    with np.errstate(all="ignore"):
        f = np.array([np.broadcast_to(rate(values, np), samples) for rate in rates])
    x = np.array([values[name] for name in names])
    matrix = np.vstack([f, *(x[i] * f[j] + x[j] * f[i] for i, j in pairs)]).T
    if not np.isfinite(matrix).all():
        return None
    kept = _kept(matrix)
    if not kept.size:
        return None
    ends = [np.concatenate([at, [at[i] * at[j] for i, j in pairs]]) for at in (np.array(first), np.array(last))]
    for own, count in ((_kept(matrix[:, : len(names)]), len(names)), (kept, matrix.shape[1])):  # sums are told first
        if contradicted := _contradicted(_reduced(own.T)[0], [end[:count] for end in ends], names, pairs):
            return Conserved([], contradicted)
    gradients = kept[: len(names)].copy()
    for (i, j), coefficients in zip(pairs, kept[len(names) :], strict=True):
        gradients[i] += coefficients * last[j]
        gradients[j] += coefficients * last[i]
    return Conserved([names[i] for i in _reduced(gradients.T)[1]])


def _tied(asked: Mapping[str, set[str]]) -> set[str]:
    """The states that may be in a kept function: not one whose rate alone has something that no kept function can have
    in it, as a control; and none that is left alone by that.

    asked: the names in the rate of each.
    """
    tied = set(asked)
    while alone := {name for name in tied if _only(name, tied, asked)}:
        tied -= alone
    return tied


def _only(name: str, tied: Collection[str], asked: Mapping[str, set[str]]) -> bool:
    """Whether the rate of one of these states has something in it, none of them, that no other rate of theirs has."""
    return bool(asked[name].difference(tied, *(asked[other] for other in tied if other != name)))


def spread(names: int, samples: int) -> np.ndarray:
    """Samples of no meaning between 0.1 and 0.9, the same each time.

    names: how many values each sample has.
    samples: how many there are.

    Shape (names, samples).
    """
    irrational = np.sqrt(np.arange(names) + math.e)
    return 0.1 + 0.8 * (np.outer(irrational, np.arange(1, samples + 1)) % 1.0)


def _contradicted(
    kept: np.ndarray, ends: Sequence[np.ndarray], names: Sequence[str], pairs: Sequence[tuple[int, int]]
) -> Contradicted | None:
    """The kept function that differs most, relative to the sizes of its terms; None where all are the same."""
    sizes = np.abs(kept) * np.maximum(*map(np.abs, ends))
    differ = np.abs(kept @ (ends[1] - ends[0])) - SAME * sizes.sum(axis=1)
    if not differ.max(initial=0.0) > ROUNDING**2:
        return None
    g = kept[np.argmax(differ)]
    terms = [(name,) for name in names] + [(names[i], names[j]) for i, j in pairs]
    counted = np.flatnonzero(np.abs(g) > RANK * np.abs(g).max()).tolist()
    last = max(names.index(name) for k in counted for name in terms[k])
    told = _sum([(g[k], terms[k]) for k in counted])
    return Contradicted(told, names[last], *(float(g @ end) for end in ends))


def _sum(products: Sequence[tuple[float, tuple[str, ...]]]) -> str:
    """A sum of coefficients times names, in words."""
    text = ""
    for coefficient, names in products:
        factor = "" if abs(abs(coefficient) - 1) < RANK else f"{abs(coefficient):.4g}*"
        term = f"{names[0]}**2" if len(set(names)) < len(names) else "*".join(names)
        text += (" - " if coefficient < 0 else " + " if text else "") + factor + term
    return text.strip()


def _kept(matrix: np.ndarray) -> np.ndarray:
    """The combinations of columns that are zero, each of length 1, by columns.

    Columns are taken relative to their size, which depends on units: a rate of 1e-6 is not one of zero.
    """
    sizes = np.abs(matrix).max(axis=0)
    sizes[sizes == 0] = 1.0
    kept: np.ndarray = _null_space(matrix / sizes) / sizes[:, None]
    kept /= np.linalg.norm(kept, axis=0)
    return kept


def _null_space(matrix: np.ndarray) -> np.ndarray:
    """An orthonormal basis of the null space, by columns."""
    _, sizes, vectors = np.linalg.svd(matrix, full_matrices=False)  # there are more rows than columns
    rank = int((sizes > ROUNDING * sizes.max(initial=0.0)).sum())
    return vectors[rank:].T


def _reduced(rows: np.ndarray) -> tuple[np.ndarray, list[int]]:
    """The rows after Gauss-Jordan elimination, those that are independent, and the column of the pivot of each."""
    rest, open_, columns = rows.copy(), np.ones(len(rows), bool), list[int]()
    while np.abs(rest[open_]).max(initial=0.0) > RANK:
        among = np.where(open_[:, None], np.abs(rest), 0.0)
        row, column = np.unravel_index(np.argmax(among), rest.shape)
        pivot = rest[row] / rest[row, column]
        rest -= np.outer(rest[:, column], pivot)
        rest[row] = pivot
        open_[row] = False
        columns.append(int(column))
    return rest[~open_], columns
