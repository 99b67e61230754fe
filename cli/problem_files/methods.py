"""`trajopt methods`: the methods that a mesh may name."""

from __future__ import annotations

from ..errors import command
from ..output.printing import print_table


@command
def methods() -> None:
    """List the methods that a mesh may name.

    Example: trajopt methods
    """
    from ...transcription.schemes.table import METHODS

    rows = [(m.name, m.family, m.order, m.ends, m.state, m.control, m.source) for m in METHODS.values()]
    print_table(("method", "family", "order", "ends", "state", "control", "source"), rows)
    print(
        "\nn: the degree. order: of states at the knots and of integrals. state, control: degrees of the interpolants."
    )
    for method in METHODS.values():
        if method.note:
            print(f"{method.name}: {method.note}")
