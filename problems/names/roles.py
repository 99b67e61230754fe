"""What a name is, its role, and where names of some roles cannot stand."""

from __future__ import annotations

from ..expressions.tree import Name

# Roles of names that have a value at every time.
STATE, CONTROL, ALGEBRAIC, RATE = "state", "control", "algebraic variable", "rate"
DELAYED = "state at an earlier time"
TABLE = "table"
VARYING = frozenset({"time", STATE, CONTROL, ALGEBRAIC, RATE, DELAYED})


def with_article(role: str) -> str:
    """ "a state", "an expression"."""
    return f"{'an' if role[0] in 'aeo' else 'a'} {role}"


def not_at_ends(name: Name, role: str) -> tuple[str, str] | None:
    """What is wrong with a name in an expression about the two ends, and the remedy."""
    over_time = f"{name.name} has a value at every time, but this expression is about the two ends"
    if name.end and role in ("parameter", "static parameter"):
        return f"{name.name} is a {role} and has only one value", f"write {name.name}"
    if role == RATE:
        return over_time, "name it under expressions:, and write [final] or [initial] after that name"
    if not name.end and role in VARYING:
        return over_time, f"write {name.name}[final] or {name.name}[initial]"
    return None


def not_in_history(name: str, role: str) -> tuple[str, str] | None:
    """What is wrong with a name in the history of a state, and the remedy."""
    if role in ("parameter", "time", "unknown"):
        return None
    what = f"{name} is {with_article(role)}, and a history is known before the solution is"
    return what, "write it as a number, or an expression of t and parameters"
