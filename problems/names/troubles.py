"""What is wrong with a name in an expression, and the remedy."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping
from typing import Any

from ..expressions.delays import delay_of
from ..expressions.tree import Name
from ..text import did_you_mean
from ..wishes.names import name_wish
from ..yaml.document import Path
from . import lookups
from .delays import no_delay
from .occurrences import BOUNDARY, CONSTANT, GUESS, HISTORY, MEASURED, TRAJECTORY
from .roles import STATE, TABLE, VARYING, not_at_ends, not_in_history, with_article

# Looking for a similar name among thousands takes time.
MAX_SUGGESTIONS = 20
MAX_KNOWN = 500

INTEGRAL = "integral."  # integral.work: the value of an integral

Trouble = tuple[str, str]
"""What is wrong, and the remedy."""


class Troubles:
    """roles, tables: as of `symbols.Symbols`. integrals: their names. found: the section of what is to be found."""

    def __init__(
        self,
        roles: Mapping[str, str],
        tables: Mapping[str, Any],
        integrals: Collection[str],
        found: str,
    ) -> None:
        self.roles, self.tables, self.integrals, self.found = roles, tables, integrals, found
        self._suggested = 0

    def of(self, name: Name, context: str, path: Path) -> Trouble | None:
        """What is wrong with a name, and the remedy; None for nothing.

        name: with the end of time that it is taken at, if any.
        context: what the expression is for, such as CONSTANT or TRAJECTORY.
        path: of the expression.
        """
        role, found = self.roles.get(name.name), None
        delay = delay_of(name.name)
        if delay and (role is None or context != TRAJECTORY):
            found = no_delay(delay, self.roles, STATE)
        elif role is None:
            found = self._unknown(name.name, context, path)
        elif role == TABLE:
            found = f"{name.name} is a table of data", lookups.as_called(name.name, self.tables)
        elif context == HISTORY:
            found = not_in_history(name.name, role)
        elif context == CONSTANT and role not in ("parameter", "unknown"):
            found = (
                f"{name.name} is {with_article(role)}, but this value must be known before the solution is",
                "use numbers and parameters here, and put conditions on other names under constraints:",
            )
        elif context in (GUESS, MEASURED) and name.end:
            found = f"{name.name}[{name.end}] is a value at one end, which is not known here", f"write {name.name}"
        elif context == TRAJECTORY and name.end:
            found = (
                f"{name.name}[{name.end}] is a value at one end, but this expression is taken at every time",
                f"write {name.name}, or move the expression to constraints.boundary or to the terminal objective",
            )
        elif context == BOUNDARY:
            found = not_at_ends(name, role)
        return found

    def _unknown(self, name: str, context: str, path: Path) -> Trouble:
        what = f'unknown name "{name}"'
        if name.endswith("]"):
            return self._no_rate(name.partition("[")[0])
        if name.startswith(INTEGRAL):
            return self._no_integral(name.removeprefix(INTEGRAL), context)
        varying = [n for n, role in self.roles.items() if role in VARYING]
        if wish := name_wish(name, path, varying, [n for n in varying if self.roles[n] == STATE]):
            return what, wish
        if "." in name:
            remedy = "write a plain name; ends of phases, as boost.m[final], are for links: and the terminal objective"
            return f"{what}: expressions know no modules and no attributes", remedy
        declared = _declared(name, context, self.found)
        like = self._like(name, context)
        numbered = re.fullmatch(r"did you mean (\w+?)\d*\?", like)  # u1 and u2 beside u: it may be one more
        if numbered and numbered[1] == name.rstrip("0123456789"):
            return what, f"{like} If not, {declared}"
        return what, like or declared

    def _like(self, name: str, context: str) -> str:
        """The question after the known name that is most like this one; "" where there is none."""
        if self._suggested >= MAX_SUGGESTIONS:
            return "declare it"
        self._suggested += 1
        known = [n for n, role in self.roles.items() if role == "parameter" or (context != CONSTANT and n != "?")]
        return did_you_mean(name, [*known[:MAX_KNOWN], "pi"])

    def _no_integral(self, name: str, context: str) -> Trouble:
        """What is wrong with integral.name, which is no value of an integral here."""
        if name not in self.integrals:
            remedy = did_you_mean(name, self.integrals, f"declare it under integrals: as {name}: and the integrand")
            return f'there is no integral "{name}"', remedy
        whole = f"integral.{name} is known at the final time"
        if context == BOUNDARY:
            return f"integral.{name} is one number", f"write integral.{name}, without [ ]"
        if context == CONSTANT:
            return (
                f"{whole}, but this value must be known before the solution is",
                "put the condition under constraints:",
            )
        return f"{whole}, but this expression is taken at every time", f"write {name} for the integral so far"

    def _no_rate(self, name: str) -> Trouble:
        """What is wrong with name[rate], which is no implicit rate."""
        if self.roles.get(name) == STATE:
            remedy = f"write its rate instead, or leave out rate: of {name} to make it implicit"
            return f"the rate of {name} is given, so {name}[rate] is not an unknown", remedy
        return f'unknown name "{name}[rate]"', "only a state without rate: and accel: is known by its rate"


def _declared(name: str, context: str, found: str) -> str:
    """How a name is declared that an expression uses; found: the section of what is to be found."""
    given = f"under parameters: as {name}: 1.0"
    if context == CONSTANT:
        return f"declare it, for example {given}"
    return f"declare it: under {found}: as {name}: {{}} if it is to be found, {given} if it is given"
