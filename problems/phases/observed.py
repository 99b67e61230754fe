"""Measurements while an end of the time is free: phases whose measurements lie between two times that are known.

What is measured at t_k is the state at a knot, and a knot is a part of the duration, which is not known then. So a file
without phases is one of up to three, the trajectory going on from each to the next:

    before      from a free initial time to the first measurement
    measured    from the first measurement, or a given initial time, to the last one, or a given final time
    after       from the last measurement to a free final time

It lasts from the first measurement to the last one at least.
"""

from __future__ import annotations

from typing import Any

from ..schema.declarations import TimeEnd
from ..schema.phases import PhaseEntry
from ..schema.spec import Spec
from ..tables.series import TIME

BEFORE, MEASURED, AFTER = "before", "measured", "after"


def is_free(end: TimeEnd) -> bool:
    """Whether a file leaves a time open."""
    pinned = end.lower is not None and end.upper is not None and end.lower.text == end.upper.text
    return end.value is None and not pinned


def observed_phases(spec: Spec) -> dict[str, PhaseEntry]:
    """The phases that measurements make of a file, in order; none where both ends of its time are given."""
    times = [time for entry in spec.measurements.values() for time in entry.data.get(TIME, ())]
    begins, ends = is_free(spec.time.initial), is_free(spec.time.final)
    if spec.phases or spec.waypoints or spec.discrete or not times or not (begins or ends):
        return {}
    first, last = min(times), max(times)
    time: dict[str, Any] = {"final": last} if ends else {}
    if begins and ends and first == last:
        return {BEFORE: _observed(spec, time), AFTER: PhaseEntry()}
    own = {BEFORE: PhaseEntry.model_validate({"time": {"final": first}})} if begins else {}
    return own | {MEASURED: _observed(spec, time)} | ({AFTER: PhaseEntry()} if ends else {})


def _observed(spec: Spec, time: dict[str, Any]) -> PhaseEntry:
    own = PhaseEntry.model_validate({"time": time})
    return own.model_copy(update={"measurements": spec.measurements})
