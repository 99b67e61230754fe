"""`trajopt list`: the problems that ship."""

from __future__ import annotations

from ..errors import command
from ..output.printing import print_table


@command
def list_() -> None:
    """List the shipped problems; each can be solved by its name.

    Example: trajopt list
    """
    from ...problems.catalog import shipped
    from ...problems.load import load

    rows = []
    for name, path in shipped().items():
        spec = load(path)
        reference = "" if spec.reference is None else f"{spec.reference.objective:.10g}"
        rows.append((name, spec.name, reference, spec.source))
    print_table(("name", "problem", "reference", "source"), rows)
