"""Names that are declared and then play no part."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from ..expressions.tree import Lookup, Name, nodes
from ..measured import compared
from ..models import find_model
from ..names.occurrences import uses
from ..names.symbols import ALGEBRAIC, CONTROL, TABLE, Symbols
from ..schema.spec import Spec
from ..yaml.locations import Finding

# What should stand in some expression: its role, and the section that declares it.
_USED = {
    "parameter": "parameters",
    "expression": "expressions",
    CONTROL: "controls",
    ALGEBRAIC: "algebraic",
    "static parameter": "optimize",
    TABLE: "tables",
}


def unused(spec: Spec, symbols: Symbols, called: Iterable[str] = ()) -> Iterator[Finding]:
    """A warning for each name that no expression uses.

    spec: without mistakes, its functions written out.
    symbols: of it.
    called: keys of the functions that it called before.
    """
    used = [node for use in uses(spec) for node in nodes(use.expression.root)]
    named = {node.table if isinstance(node, Lookup) else node.name for node in used if isinstance(node, Lookup | Name)}
    if spec.model:
        model = find_model(spec.model)
        named |= {*model.parameters, *model.controls, *model.algebraic}
    named |= {column for entry in spec.measurements.values() for column in compared(entry, symbols)}
    outputs = {name for name, written in spec.expressions.items() if written.unit or written.note}
    outputs = {name for name in outputs if "(" not in name}.union(called)
    for name, role in symbols.roles.items():
        if role in _USED and name not in named | outputs:
            what = f"the {role} {name} is used nowhere"
            yield Finding((_USED[role], name), what, "remove it, or use it in an expression")
