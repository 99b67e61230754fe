"""All that the language adds to plain expressions, taken out of a spec in turn."""

from __future__ import annotations

from ..schema.spec import Spec
from ..yaml.locations import Finding
from .functions import without_functions
from .integrals import integrals_as_states
from .means import means_as_states
from .rates import rates_written_out
from .times import times_as_parameters


def shared_in_plain(spec: Spec, marked: bool = False) -> tuple[Spec, list[Finding]]:
    """The spec of a file, for what its top level says of several phases, and what is wrong with calls of functions.

    spec: as the schema has passed it.
    marked: see `in_plain`.
    """
    return without_functions(spec, marked)


def in_plain(spec: Spec, suffix: str = "", marked: bool = False) -> tuple[Spec, list[Finding]]:
    """The spec of one phase in plain expressions, and what is wrong with functions and integrals.

    spec: as the schema has passed it.
    suffix: of the names of parameters that are made for it, different for each phase.
    marked: whether what calls of functions were written out to says of which function it is, for checks.
    """
    spec, mistaken = without_functions(spec, marked)
    spec, refused = integrals_as_states(spec)
    return times_as_parameters(means_as_states(rates_written_out(spec)), suffix), mistaken + refused
