"""What came of one shipped problem, beside what is published of it: a row of the table, plain data."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, fields, replace
from decimal import Decimal
from math import floor, inf, isfinite, log10
from typing import Any

from ...problems.lean.records import dataclass
from ...problems.schema.spec import Spec
from ...transcription.solution.solution import Solution
from ..audit.check import Check

MOST_DIGITS = 8.0
"""What is told of an agreement at most: the solver's tolerance is 1e-8."""

SHOWN = 10
"""Significant digits of a reference that are asked for, as many as the table shows."""

OF_DIGIT, FINEST = 0.5, 1e-10
"""Of half a unit of the last digit of a reference: the error bar that tells it. And the least, of 1 + |J|."""

EXACT = "exact"
"""What the source of an exact value begins with."""

ROUNDED = 1e-6
"""Of half a digit: what a decimal number is off in binary."""

COMPLETE, FINE, EXCLUDED, SHORT = "all", "all, finer", "reference is off", "short"
"""All digits of the reference agree; those of a finer solve do; the error bar of that one excludes the reference, which
its mesh or its rounding limits; or they do not."""

SLOW = frozenset({
    *("bouncing_pendulum", "coulomb_friction", "delta_iii", "fed_batch_inducer", "free_flying_robot", "goddard"),
    *("goddard_speed_limit", "hang_glider", "min_time_climb", "quadrotor", "reorientation"),
})  # fmt: skip
"""Shipped problems that take more than some 3 s."""


@dataclass(frozen=True)
class Finer:
    """The same problem with an option of `trajopt solve` that gives more digits, and what came of it."""

    option: str
    objective: float
    bar: float

    @property
    def told(self) -> str:
        return f"{self.option} gives {self.objective:.12g} +- {self.bar:.1e}"


@dataclass(frozen=True)
class Row:
    """A shipped problem, solved and verified.

    solved: to the accuracy that its file asks for. message: how the solve ended. objective: None without a finite one.
    bar: |J - J*| is at most that, None where there is no error bar. reference, tolerance, source: of the file, None
    and "" without one. segments, points: of the last meshes of all phases. iterations: over all meshes. checks: how
    many `verify` made; failed: the names of those that failed. seconds: of the solve; verify_seconds: of the checks.
    finer: the problem with more digits, where the default does not agree in all those of the reference.
    """

    name: str
    tags: tuple[str, ...] = ()
    solved: bool = False
    message: str = ""
    objective: float | None = None
    bar: float | None = None
    reference: float | None = None
    tolerance: float | None = None
    source: str = ""
    segments: int = 0
    points: int = 0
    meshes: int = 0
    iterations: int = 0
    checks: int = 0
    failed: tuple[str, ...] = ()
    seconds: float = 0.0
    verify_seconds: float = 0.0
    finer: Finer | None = None

    @property
    def difference(self) -> float:
        """|J - the reference|; infinite where one is missing."""
        if self.objective is None or self.reference is None:
            return inf
        return abs(self.objective - self.reference)

    @property
    def digits(self) -> float | None:
        """Digits in which the objective and the reference agree, no more than the reference has; None without one.

        Of a reference that is zero: digits behind the point.
        """
        if self.objective is None or self.reference is None:
            return None
        scale = abs(self.reference) or 1.0
        agreed = -log10(self.difference / scale) if self.difference else inf
        return round(max(min(agreed, self._digits_of_reference(scale), MOST_DIGITS), 0.0), 1)

    def _digits_of_reference(self, scale: float) -> float:
        """All, of a value that is exact; else to half a unit of the last digit that its file gives."""
        if self.reference is None or self.source.startswith(EXACT):
            return inf
        last = int(Decimal(repr(self.reference)).normalize().as_tuple().exponent)
        return -log10(0.5 * 10.0**last / scale)

    @property
    def half_digit(self) -> float:
        """Half a unit of the last digit of the reference that is asked for: the last one that its file gives, or the
        tenth; behind the point of a reference that is zero, and of a whole number, which is exact."""
        assert self.reference is not None
        first = floor(log10(abs(self.reference))) if self.reference else 0
        given = int(Decimal(repr(self.reference)).normalize().as_tuple().exponent)
        shown = first + 1 - SHOWN
        return 0.5 * 10.0 ** (shown if self.reference.is_integer() else max(given, shown))

    @property
    def complete(self) -> bool | None:
        """Whether the objective agrees with all digits of the reference; None without one."""
        return None if self.reference is None else self.difference <= self.half_digit * (1 + ROUNDED)

    @property
    def accuracy_of_digits(self) -> float:
        """The accuracy that tells all digits of the reference, as `--accuracy` takes it."""
        assert self.reference is not None
        wanted = OF_DIGIT * self.half_digit / (1 + abs(self.reference))
        return max(float(f"{wanted:.0e}"), FINEST)

    @property
    def standing(self) -> str:
        """How the objective stands to the digits of the reference: one of COMPLETE, FINE, EXCLUDED and SHORT, or ""
        without a reference."""
        if self.reference is None:
            return ""
        if self.complete or self.finer is None:
            return COMPLETE if self.complete else SHORT
        apart, half = abs(self.finer.objective - self.reference), self.half_digit * (1 + ROUNDED)
        if apart <= half:
            return FINE
        return EXCLUDED if apart > self.finer.bar + half and not self.source.startswith(EXACT) else SHORT

    @property
    def holds(self) -> bool | None:
        """Whether the error bar and the reference's tolerance cover the difference; None where there is no bar."""
        if self.bar is None or self.reference is None or self.tolerance is None:
            return None
        return self.difference <= self.bar + self.tolerance

    @property
    def passed(self) -> bool:
        return self.solved and not self.failed and self.holds is not False

    @property
    def verdict(self) -> str:
        """Of `verify`, in words."""
        if not self.checks:
            return "not made"
        return f"{len(self.failed)} of {self.checks} failed" if self.failed else "passed"

    @property
    def told(self) -> dict[str, Any]:
        """All of it, as JSON has it."""
        made = {"digits": self.digits, "holds": self.holds, "standing": self.standing}
        return {**asdict(self), "tags": list(self.tags), "failed": list(self.failed), **made}

    @property
    def kept(self) -> dict[str, Any]:
        """What does not vary from run to run: no times, the objective to 12 digits and its bar to 2."""
        lasting = {key: value for key, value in self.told.items() if key not in VARYING}
        for key, digits in (("objective", 12), ("bar", 2)):
            if lasting[key] is not None:
                lasting[key] = float(f"{lasting[key]:.{digits}g}")
        if self.finer:
            objective, bar = float(f"{self.finer.objective:.12g}"), float(f"{self.finer.bar:.2g}")
            lasting["finer"] = asdict(replace(self.finer, objective=objective, bar=bar))
        return lasting


VARYING = ("seconds", "verify_seconds", "digits", "holds", "standing")
"""What is not kept: times, and what follows from the rest."""


def row_from(told: Mapping[str, Any]) -> Row:
    """The row that `kept` or `told` tells."""
    known = {field.name for field in fields(Row)}
    values: dict[str, Any] = {
        key: tuple(value) if isinstance(value, list) else value for key, value in told.items() if key in known
    }
    finer = values.get("finer")
    return Row(**{**values, "finer": Finer(**finer) if finer else None})


def row_of(name: str, spec: Spec, solution: Solution, checks: list[Check], seconds: tuple[float, float]) -> Row:
    """The row of a problem that was solved or not.

    name: of the file.
    spec: what the file says.
    solution: of it.
    checks: of `verify`.
    seconds: of the solve and of the checks.
    """
    reference, last = spec.reference, solution.meshes[-1]
    return Row(
        name=name,
        tags=tuple(spec.tags),
        solved=solution.solved and not solution.inaccurate,
        message=solution.inaccurate if solution.solved and solution.inaccurate else solution.status.message,
        objective=_finite(solution.objective),
        bar=_finite(solution.objective_error.bar),
        reference=reference.objective if reference else None,
        tolerance=reference.tolerance if reference else None,
        source=reference.source if reference else "",
        segments=last.segments,
        points=sum(len(mesh.fractions) for mesh in last.grids),
        meshes=len(solution.meshes),
        iterations=sum(mesh.iterations for mesh in solution.meshes),
        checks=len(checks),
        failed=tuple(dict.fromkeys(check.name for check in checks if not check.passed)),
        seconds=seconds[0],
        verify_seconds=seconds[1],
    )


def _finite(number: float) -> float | None:
    return float(number) if isfinite(number) else None
