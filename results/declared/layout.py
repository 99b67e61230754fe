"""The layout of a result file, declared once: what is written, and what a file must have before it is read.

What is not declared is never opened. The words are those of `words`.
"""

from __future__ import annotations

from ...transcription.engines.outcome import Status
from .words import FLAG, NUMBER, OPTION, TEXT, TEXTS, WHOLE, Array, Attribute, Each, Group, Size

POINTS, SEGMENTS, STATES = Size("points"), Size("segments"), Size("states", least=0)
KNOTS, SAMPLES = Size("segments", plus=1), Size("segments", plus=1, steps=True)


UNITS = Attribute(TEXT, optional=True)
"""Of every array, by the name `units`."""

MAX_DEGREE = 1000
"""No method has more: a file cannot ask for a scheme of endless size."""

_STATUS = Attribute(TEXT, one_of=tuple(status.name.lower() for status in Status))
_OBJECTIVE = {
    "objective": Attribute(NUMBER),
    "objective_error": Attribute(NUMBER, optional=True, above=0.0),  # results of older versions have no error bar
    "objective_corrected": Attribute(NUMBER, optional=True),
}
_SECONDS = {"seconds_*": Attribute(NUMBER, finite=True)}

HEAD = Group(attributes={"problem": Attribute(TEXT), "solved": Attribute(FLAG)})
"""What tells whose result it is."""

VERSION = Group(attributes={"format_version": Attribute(WHOLE)})
"""What tells whether the rest can be as declared."""

_CURVE = {"points": Array(NUMBER, (POINTS,)), "dense": Array(NUMBER, (SAMPLES,))}


def _curves_over(where: str) -> dict[str, Array | Group | Each]:
    """The curves of a phase at its points, or on the dense grid, over their times."""
    curve = _CURVE[where]
    return {
        "time": Array(NUMBER, curve.sizes, ordered="times"),
        "state": Each(curve, names="states"),  # none where there is no time
        "control": Each(curve, names="controls"),
        "algebraic": Each(curve, names="algebraic", optional=True),  # the oldest results lack this and the next
        "output": Each(curve, names="outputs", optional=True),
        "path": Each(curve, names="path constraints", optional=True),
        "costate": Each(curve, names="states", or_none=True, optional=True),
    }


PRICES = Each(Array(NUMBER), optional=True)  # older results have none

_MEASUREMENT, _ESTIMATE = Size("measurements"), Size("estimates")

MEASURED = Group(
    {
        "measurement": Array(WHOLE, (_MEASUREMENT,)),
        "time": Array(NUMBER, (_MEASUREMENT,), ordered="times"),
        "value": Array(NUMBER, (_MEASUREMENT,)),
        "deviation": Array(NUMBER, (_MEASUREMENT,)),
        "model": Array(NUMBER, (_MEASUREMENT,)),
    },
    {"expression": Attribute(TEXT)},
)
"""One quantity that was measured, and the solution at the same times."""

ESTIMATES = Group(
    {
        "parameter": Array(TEXT, (_ESTIMATE,), names="estimates"),
        "other": Array(TEXT, (_ESTIMATE,), names="estimates"),
        "value": Array(NUMBER, (_ESTIMATE,)),
        "standard_error": Array(NUMBER, (_ESTIMATE,)),
        "correlation": Array(NUMBER, (_ESTIMATE, _ESTIMATE)),
    },
    {
        "residuals": Attribute(NUMBER),
        "measurements": Attribute(WHOLE, above=-1),
        "free": Attribute(WHOLE),
        "scale": Attribute(NUMBER),
        "given": Attribute(FLAG),
        "missing": Attribute(TEXT),
    },
    optional=True,
)
"""Parameters that were estimated from measurements."""

_ARC = (Size("arcs"),)

ARCS = Group(
    {
        "arc": Array(WHOLE, _ARC),
        **dict.fromkeys(("start", "end"), Array(NUMBER, _ARC, finite=True)),
        "bound": Array(NUMBER, _ARC),
        **dict.fromkeys(("name", "kind", "on", "by"), Array(TEXT, _ARC)),
    },
    optional=True,  # where something is on a bound; older results have none
)
"""When a phase is on which of its bounds."""

PHASE = Group({
    "knots": Array(NUMBER, (KNOTS,), ordered="times"),
    "knot": Array(NUMBER, (KNOTS,), optional=True),  # a dimension without values, which older results lack
    "points": Group(_curves_over("points")),
    "dense": Group({**_curves_over("dense"), "epsilon": Each(_CURVE["dense"], names="states")}),
    "error": Group(
        {
            "segment": Array(WHOLE, (SEGMENTS,)),
            "state": Array(TEXT, (STATES,), names="states"),
            "eta": Array(NUMBER, (SEGMENTS, STATES)),
            "relative": Array(NUMBER, (SEGMENTS,), optional=True),  # older ones lack it and the next
            "excess": Array(NUMBER, (SEGMENTS,), optional=True),
            "objective": Array(NUMBER, (SEGMENTS,), optional=True),  # where there is an error bar
        },
        {
            "overshoot_share": Attribute(NUMBER, optional=True),  # where anything has bounds
            "overshoot_name": Attribute(TEXT, along="overshoot_share"),
            "overshoot_amount": Attribute(NUMBER, along="overshoot_share"),
            "overshoot_unit": Attribute(TEXT, along="overshoot_share"),
            "overshoot_time": Attribute(NUMBER, along="overshoot_share"),
            "overshoot_lasts": Attribute(NUMBER, optional=True),  # results of older versions have none
        },
    ),
    "parameter": Each(Array(NUMBER), names="parameters"),
    "price": PRICES,
    "arcs": ARCS,
    "complementarity": Each(
        Group({"product": Array(NUMBER), "time": Array(NUMBER), "allowed": Array(NUMBER, finite=True)}),
        names="pairs",
        or_none=True,
        optional=True,
    ),
    "measured": Each(MEASURED, names="quantities", own=True, optional=True),
})  # fmt: skip
"""One phase. Another one repeats it."""

_GRID = {
    "edges": Array(NUMBER, (KNOTS,), unless="phase", ordered="edges"),
    "degree": Array(WHOLE, (SEGMENTS,), optional=True, limits=(0, MAX_DEGREE)),  # of a method with a choice
    "differential": Array(WHOLE, (SEGMENTS,), along="degree", limits=(0, 1)),
    "segment": Array(WHOLE, (SEGMENTS,), along="degree"),
}
_METHOD = {
    "method": Attribute(TEXT),
    "segments": Attribute(WHOLE, size=SEGMENTS),
    "substeps": Attribute(WHOLE, optional=True, above=0),  # of shooting
    "control": Attribute(TEXT, along="substeps"),
}

MESH = Group(
    {**_GRID, "phase": Each(Group(_GRID, _METHOD), names="phases", own=True, optional=True)},
    {
        **_METHOD,
        "tolerance": Attribute(NUMBER, finite=True, above=0.0),
        "status": _STATUS,
        **_OBJECTIVE,
        "max_eta": Attribute(NUMBER),
        "relative_error": Attribute(NUMBER),
        "iterations": Attribute(WHOLE, above=-1),
        "unknowns": Attribute(WHOLE, above=-1),
        "constraints": Attribute(WHOLE, above=-1),
        **_SECONDS,
    },
)
"""One mesh of the history; with several phases, that of each is in `phase`."""

_UNKNOWN, _CONSTRAINT, _RECORD = (Size(symbol, least=0) for symbol in ("unknowns", "constraints", "records"))

_NUMBERS = Size("numbers", least=0)

SENSITIVITY = Group(
    {
        "number": Array(TEXT, (_NUMBERS,)),
        "value": Array(NUMBER, (_NUMBERS,), finite=True),
        "unit": Array(TEXT, (_NUMBERS,)),
        "derivative": Array(NUMBER, (_NUMBERS,)),
        "note": Array(TEXT, (_NUMBERS,)),
    },
    {"missing": Attribute(TEXT)},
    optional=True,  # results of older versions have none
)
"""The derivative of the objective by each number of the file."""

SOLVER = Group(
    {
        "iterations": Group({"number": Array(WHOLE, (_RECORD,)), "*": Array(NUMBER, (_RECORD,))}),
        "unknown": Array(WHOLE, (_UNKNOWN,)),
        "constraint": Array(WHOLE, (_CONSTRAINT,)),
        "z": Array(NUMBER, (_UNKNOWN,)),
        "z_lower": Array(NUMBER, (_UNKNOWN,)),
        "z_upper": Array(NUMBER, (_UNKNOWN,)),
        "y": Array(NUMBER, (_CONSTRAINT,)),
    },
    {
        "violations": Attribute(TEXTS),
        "involved": Attribute(TEXTS, optional=True),  # results of older versions have none
        "unmet": Attribute(TEXTS),
        "unmet_count": Attribute(WHOLE, above=-1),
        "stopped": Attribute(TEXT),
        "program": Attribute(TEXT, optional=True),
        "notes": Attribute(TEXTS, optional=True),  # results of older versions have none
        "relief": Attribute(TEXTS, optional=True),
        "continuation": Attribute(TEXTS, optional=True),
        "discarded": Attribute(TEXTS, optional=True),
        "discarded_iterations": Attribute(WHOLE, optional=True),
        **_SECONDS,
        "*": Attribute(OPTION),
    },
)
"""The point of the solver, how it came there, and its options."""

RESULT = Group(
    {
        "spec": Group(
            {"text": Array(TEXT), "full": Array(TEXT), "parameter": Each(Array(NUMBER), names="givens", optional=True)},
            {"overrides": Attribute(TEXTS), "override_values": Attribute(TEXTS, optional=True)},
        ),
        "phase": Each(PHASE, names="phases", least=1, own=True),
        "mesh": Each(MESH, numbered=True, least=1, own=True),
        "solver": SOLVER,
        "price": PRICES,
        "estimates": ESTIMATES,
        "sensitivity": SENSITIVITY,
    },
    {
        "format": Attribute(TEXT),
        **VERSION.attributes,
        **HEAD.attributes,
        "status": _STATUS,
        "message": Attribute(TEXT),
        "remedy": Attribute(TEXT),
        "trouble": Attribute(TEXT),
        **_OBJECTIVE,
        "objective_error_missing": Attribute(TEXT, optional=True),
        "sense": Attribute(TEXT, one_of=("minimize", "maximize")),
        "created": Attribute(TEXT),
        "command": Attribute(TEXT),
        "trajopt_version": Attribute(TEXT),
        "pyomo_version": Attribute(TEXT),
        "ipopt_version": Attribute(TEXT),
    },
)
"""The whole file."""
