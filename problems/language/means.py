"""What is measured of a control: its mean around the time, which is a difference of two values of an integral.

The value of a control at one instant costs nothing, so that it may be whatever was measured there; its mean over an
interval is determined. So a column of what depends on a control, or on an algebraic variable, is compared with

    (U(b_k) - U(a_k)) / (b_k - a_k),        dU/dt = h(t, x, u, p)

where U is a state that starts at zero, as that of a named integral, and a_k to b_k is around t_k (`measured.spans`).
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from ..expressions.expression import Expression
from ..names.variables import free_name, reference, states
from ..schema.declarations import IntegralState
from ..schema.measurements import MeanEntry, MeasuredEntry
from ..schema.phases import PhaseEntry
from ..schema.spec import Spec
from ..yaml.document import Path
from .integrals import ZERO


def means_as_states(spec: Spec) -> Spec:
    """The spec of one phase with a state for each column that is compared with a mean.

    spec: in plain expressions but for the ends of time.
    """
    instant = _instant(spec)
    added: dict[str, IntegralState] = {}
    entries: dict[str, MeasuredEntry] = dict(spec.measurements)
    for name, entry in spec.measurements.items():
        told = _told(spec, entry)
        means = {column: own for column, own in told.items() if any(leaf.name in instant for leaf in own.leaves)}
        if not means or spec.discrete:
            continue
        compare = dict(told)
        for column, own in means.items():
            state = free_name(_word(f"integral_of_{column}_in_{name}"), spec, added)
            added[state] = IntegralState.model_construct(rate=own, initial=ZERO)
            compare[column] = reference(state)
        entries[name] = MeanEntry.model_construct(**{**dict(entry), "compare": compare}, means=means)
    if not added:
        return spec
    return spec.model_copy(update={"states": {**spec.states, **added}, "measurements": entries})


def place_of_mean(spec: Spec | PhaseEntry, path: Path) -> Path:
    """Where in the file something is told of that concerns the state of a mean.

    spec: that has the measurements, as it was written.
    path: in its plain form.
    """
    if path[:1] == ("states",) and len(path) > 1:
        for name, entry in spec.measurements.items():
            for column in (*entry.compare, *entry.data):
                if str(path[1]).rstrip("_") == _word(f"integral_of_{column}_in_{name}").rstrip("_"):
                    return ("measurements", name, "compare", column)
    return path


def _told(spec: Spec, entry: MeasuredEntry) -> dict[str, Expression]:
    """Column -> what it is compared with."""
    if entry.compare:
        return entry.compare
    known = {state.name for state in states(spec)} | {*spec.controls, *spec.algebraic, *spec.expressions}
    return {column: reference(column) for column in entry.data if column in known}


def _instant(spec: Spec) -> set[str]:
    """The names whose value depends on a control or an algebraic variable at the same time."""
    found = {*spec.controls, *spec.algebraic}
    while more := set(_depending(spec, found)) - found:
        found |= more
    return found


def _depending(spec: Spec, on: set[str]) -> Iterator[str]:
    for name, own in spec.expressions.items():
        if any(leaf.name in on for leaf in own.value.leaves):
            yield name


def _word(text: str) -> str:
    return re.sub(r"\W+", "_", text)
