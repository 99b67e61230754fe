"""Of two things that are never negative, one is zero at every time: a gap and a contact force."""

from __future__ import annotations

from itertools import pairwise
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, field_validator

from ..expressions.expression import Expression
from .fields import Entry, Formula, Number, Text, mistake

RELAX = [1.0, 0.1, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6]
MAX_STEPS = 100


def _listed(value: Any) -> Any:
    return value if isinstance(value, list) else [value]


class ComplementarityEntry(Entry):
    """a >= 0, b >= 0 and a*b = 0 at every point of the mesh, by a*b <= relax, which goes down step by step."""

    name: Text = Field("", description="name in results; default made from a and b")
    a: Formula = Field(description="what may not be negative, as a gap: an expression of t, x, u")
    b: Formula = Field(description="what may not be negative, and only not zero where a is, as a contact force")
    relax: Annotated[list[Number], BeforeValidator(_listed), Field(min_length=1, max_length=MAX_STEPS)] = Field(
        RELAX, description="what a*b may be in each solve on the way, in its own unit; the last holds for the result"
    )

    @field_validator("relax")
    @classmethod
    def _goes_down(cls, value: list[float]) -> list[float]:
        if min(value) <= 0:
            what = f"what a*b may be is {min(value):g}, and with nothing left there is no way for the solver to move"
            raise mistake(what, "write positive numbers, such as [1, 0.01, 1e-6]")
        if any(later >= earlier for earlier, later in pairwise(value)):
            raise mistake("these numbers do not go down", "write each smaller than the one before: [1, 0.01, 1e-6]")
        return value

    @property
    def sides(self) -> tuple[tuple[str, Expression], ...]:
        """Key and expression of both."""
        return ("a", self.a), ("b", self.b)
