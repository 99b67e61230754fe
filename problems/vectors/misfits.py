"""A vector of the wrong size does not fit wherever it stands: that is told once, where its size is."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from ..text import shorten
from ..yaml.document import Path, dotted
from ..yaml.locations import Finding
from .algebra import Shape, shape_in_words


class Vector(NamedTuple):
    """shape: of it. path: where the file says that; none where it follows from something else."""

    shape: Shape
    path: Path = ()


class Misfit(NamedTuple):
    """What is told of vectors that do not go together. vectors: those that stand there, by their names."""

    finding: Finding
    vectors: Mapping[str, Vector]


def told_once(misfits: Sequence[Misfit]) -> list[Finding]:
    """What is told of vectors that do not go together.

    misfits: one for each text that has such.

    Of a vector that stands in several of them, always with vectors of one other size, only that is told.
    """
    rest = [misfit for i, misfit in enumerate(misfits) if misfit not in misfits[:i]]  # a text, for each component
    found = []
    while wrong := _most(rest):
        (name, vector), of = wrong
        found.append(_told(name, vector, of))
        rest = [misfit for misfit in rest if misfit not in of]
    return [*found, *(misfit.finding for misfit in rest)]


def _most(misfits: Sequence[Misfit]) -> tuple[tuple[str, Vector], list[Misfit]] | None:
    """The vector that stands in most of them, which are more than one; of several rather what is no state."""
    vectors = {own: [m for m in misfits if _wanted(own, m)] for misfit in misfits for own in misfit.vectors.items()}
    wrong = {own: of for own, of in vectors.items() if len(of) > 1 and len({_wanted(own, m) for m in of}) == 1}
    return max(wrong.items(), key=lambda item: (len(item[1]), "states" not in item[0][1].path), default=None)


def _wanted(own: tuple[str, Vector], misfit: Misfit) -> int:
    """The size that a vector would have to have; 0 if it is not known, or not a matter of its size."""
    name, vector = own
    if misfit.vectors.get(name) != vector or not vector.path or len(vector.shape) != 1:
        return 0
    sizes = {other.shape[-1] for key, other in misfit.vectors.items() if key != name}
    return sizes.pop() if len(sizes) == 1 and vector.shape[0] not in sizes else 0


def _told(name: str, vector: Vector, misfits: Sequence[Misfit]) -> Finding:
    size = _wanted((name, vector), misfits[0])
    where = ", ".join(dict.fromkeys(dotted(misfit.finding.path) for misfit in misfits))
    what = f"{name} is {shape_in_words(vector.shape)}, and stands with vectors of {size} in {shorten(where, 120)}"
    remedy = f"write size: {size}" if vector.path[-1] == "size" else f"give it {size} values"
    return Finding(vector.path, what, f"{remedy}, or make the others as long as it is")
