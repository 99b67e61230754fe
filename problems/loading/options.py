"""Options of the engine that a file may not set, and those that the engine does not take."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

from ..errors import Mistake
from ..schema.solving import ENGINES, LIBRARIES, Solver
from ..text import brief
from ..yaml.document import scalar
from ..yaml.locations import Finding, Locations

_LOADS = "makes the solver load a library"
_UNSAFE: dict[str, tuple[str, Callable[[Any], bool]]] = {
    "hsllib": (_LOADS, lambda value: True),
    "pardisolib": (_LOADS, lambda value: True),
    "linear_solver": (_LOADS, lambda value: str(value).lower() != "mumps"),
    "linear_system_scaling": (_LOADS, lambda value: str(value).lower() == "mc19"),
    "output_file": ("makes the solver write a file", lambda value: True),
    "print_level": ("makes the solver print all that it has", lambda value: _above(value, LOUDEST)),
    "print_options_documentation": ("makes the solver print a book", lambda value: True),
}
"""What only the command line may set: option -> what it does, and whether a value does that."""

LOUDEST = 5  # of IPOPT's 12 levels: a line for each iteration

_OPTION_FILE = "option_file_name"
"""What nothing may set: options of a file of IPOPT's own would stand in no message, no check and no result."""

OptionCheck = Callable[[str, Mapping[str, Any]], Sequence[Mistake]]
"""(engine, options) -> what the engine does not take, each mistake at solver.NAME."""


def unsafe_options(solver: Any, locations: Locations) -> list[Finding]:
    """Options that a file may not set; IPOPT also knows them in capitals, and behind a prefix such as "resto.".

    solver: the section, whatever it is.
    locations: say what the command line has set.
    """
    found = []
    for name in solver if isinstance(solver, dict) else ():
        plain = name.lower().rpartition(".")[2]
        if plain == _OPTION_FILE:
            what = f"{brief(name)} makes the solver read options that trajopt cannot check and the result does not tell"
            remedy = "remove it, and write each of its options as solver.NAME, in the file or with --set"
            found.append(Finding(("solver", name), what, remedy))
        does, unsafe = _UNSAFE.get(plain, ("", bool))
        if does and unsafe(solver[name]) and not locations.overridden(("solver", name)):
            what = f"{brief(name)} {does}, which a problem file may not do: it is data, never code"
            remedy = f"remove it, and give it on the command line: --set solver.{brief(name)}=..."
            found.append(Finding(("solver", name), what, remedy))
    return found


def _above(value: Any, most: float) -> bool:
    number = scalar(value) if isinstance(value, str) else value
    return isinstance(number, int | float) and number > most


def refused_options(solver: dict[str, Any], options: OptionCheck, known: set[str]) -> list[Finding]:
    """What the engine itself says of the options that the schema has nothing to say of.

    solver: the section.
    options: asks the engine.
    known: names of which something is said already.
    """
    own = {*Solver.model_fields, "tol", *known} - ({"library"} if solver.get("library") in LIBRARIES else set())
    plain = {name: value for name, value in solver.items() if name not in own and isinstance(value, int | float | str)}
    plain = {name: _yes_or_no(value) if isinstance(value, bool) else value for name, value in plain.items()}
    engine = solver.get("engine", "ipopt")
    mistakes = options(engine, plain) if engine in ENGINES else ()
    return [Finding(("solver", m.where.removeprefix("solver.")), m.what, m.remedy) for m in mistakes]


def _yes_or_no(value: bool) -> str:
    return "yes" if value else "no"
