"""What a problem without time, or in discrete time, cannot have."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from ..names.variables import states
from ..schema.fields import MAX_SEGMENTS
from ..schema.spec import Spec
from ..yaml.document import Path
from ..yaml.locations import Finding


def timeless_mistakes(spec: Spec, numbers: Mapping[Path, float]) -> Iterator[Finding]:
    """Every mistake of that kind.

    spec: of one phase.
    numbers: path -> value of every constant of the file that has one.
    """
    if spec.static:
        yield from _of_time(spec)
    elif spec.discrete:
        yield from _other_dynamics(spec)
        yield from _steps(spec, numbers)


def _of_time(spec: Spec) -> Iterator[Finding]:
    remedy = "write constraints: as a list of conditions on the parameters, or give the file time: and states:"
    for kind in ("path", "integral"):
        if getattr(spec.constraints, kind):
            what = f"there is no time for {kind} constraints to hold over"
            yield Finding(("constraints", kind), what, remedy)
    for name in spec.measurements:
        what = "there is no time at which anything is measured"
        yield Finding(("measurements", name), what, "write the sum of squares under minimize:, or give the file time:")
    if spec.objective.terms.integral is not None:
        what = "there is no time to integrate over"
        yield Finding(("objective", spec.objective.sense, "integral"), what, "write minimize: and the expression")


def _other_dynamics(spec: Spec) -> Iterator[Finding]:
    for state in states(spec):
        if state.rate_path[-1:] != ("next",):
            what = f"time is discrete, as other states are given by next:, but {state.name} is not"
            yield Finding(state.path, what, f"give {state.name} by next:, or all states by their rates")


def _steps(spec: Spec, numbers: Mapping[Path, float]) -> Iterator[Finding]:
    """The ends of time are whole numbers: t = 0, 1, 2, ... numbers the steps."""
    known = []
    for end in ("initial", "final"):
        entry, value = getattr(spec.time, end), numbers.get(("time", end, "value"))
        if entry.value is None:
            what = f"in discrete time the {end} time is the number of a step, and cannot be free"
            yield Finding(("time", end), what, f"write {end}: and a whole number")
        elif value is not None and value % 1 != 0:
            what = f"in discrete time the {end} time is the number of a step, not {value:g}"
            yield Finding(("time", end), what, "write a whole number")
        elif value is not None:
            known.append(value)
    if len(known) == 2 and known[1] - known[0] > MAX_SEGMENTS:
        what = f"{known[1] - known[0]:g} steps are asked for"
        yield Finding(("time", "final"), what, f"ask for 1 to {MAX_SEGMENTS}")
