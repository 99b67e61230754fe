"""Keys that a problem file does not have: those of other tools, and what does their work here."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable
from typing import Any, NamedTuple

from ..text import nearest
from ..yaml.document import Path
from .lines import entry, flow
from .mappings import kind_of
from .renamed import RENAMED


class Wish(NamedTuple):
    """What stands for a key. key: of the same mapping, "" if its work is done elsewhere. what: a remark on the word.
    line: as it should be written."""

    key: str
    what: str
    line: str


_TIMES = ("time", "the time", "t", "tf", "t_f", "final time", "duration")
_INCLUDED = "its lines here; a part that is used twice once, as x: &shared {unit: m}, and then as y: *shared"
_TABLE = "tables: {rho: {points: {h: [0, 1e4, 2e4]}, values: [1.2, 0.4, 0.09]}}, and rho(h) in an expression"
_FREE_TIME = "final: {lower: 0.1, upper: 10, guess: 1}"

Line = Callable[[Any, Path], str]
"""(the value that was given, the path of the key) -> the line."""


def _name(path: Path) -> str:
    """Of the variable that a key belongs to."""
    return str(path[-2])


def _guess(value: Any, path: Path) -> str:
    return f"guess: {{{_kind_of_guess(value)}: {{{entry(_name(path), value)}}}}} at the left margin"


def _guess_of_name(value: Any, path: Path) -> str:
    return f"{_kind_of_guess(value)}: {{{entry(str(path[-1]), value)}}}"


def _kind_of_guess(value: Any) -> str:
    """Of rows of points, expressions of t, and numbers."""
    return "keyframes" if isinstance(value, list) else "formulas" if isinstance(value, str) else "constants"


def _output(value: Any, _: Path) -> str:
    """The first of the outputs that are given, by its name if it has one."""
    named = value if isinstance(value, dict) else {"power": value[0]} if isinstance(value, list) and value else {}
    name, output = next(iter(named.items()), ("power", "u*v"))
    if isinstance(output, dict):
        output = output.get("value", output.get("expression", "u*v"))
    line = f"expressions: {{{name}: {{{entry('value', output)}}}}}"
    return f"{line}, which is stored; with its unit beside it, as unit: W, it is drawn, too"


def _dynamics(value: Any, path: Path) -> str:
    rates = value if isinstance(value, dict) and value else {"x": "v"}
    shown = list(rates.items())[:2]
    more = ", ..." if len(rates) > len(shown) else ""
    return "states: {" + ", ".join(f"{name}: {{{entry('rate', rate)}}}" for name, rate in shown) + more + "}"


def _terms(value: Any, path: Path) -> str:
    sense = "maximize" if str(path[-1]).startswith("max") else "minimize"
    return f"objective: {{{sense}: {terms(value)}}}"


def terms(value: Any) -> str:
    """The terms of an objective for what is given in their place."""
    if isinstance(value, dict):
        return flow(value)
    text = at_the_ends(str(value))
    return "{" + entry("terminal" if "[" in text else "integral", text) + "}"


def at_the_ends(text: str) -> str:
    """An expression of the ends of time, with tf, x(tf) and "minimize time" as they are written here."""
    text = re.sub(r"^(minimi[sz]e|maximi[sz]e|min|max)\s+(?=\w)", "", text.strip())
    if text.lower() in _TIMES:
        return "t[final]"
    text = re.sub(r"\b(\w+)\((?:tf|t_f|T|t_final)\)", r"\1[final]", text)
    text = re.sub(r"\b(\w+)\((?:t0|t_0|t_initial)\)", r"\1[initial]", text)
    return re.sub(r"\b(?:tf|t_f|t_final)\b", "t[final]", text)


def _ends(value: Any) -> Any:
    return at_the_ends(value) if isinstance(value, str) else value


def _bolza(value: Any, _: Path) -> str:
    """Both terms, from a mapping of their names elsewhere."""
    own = {str(key).lower(): part for key, part in value.items()} if isinstance(value, dict) else {}
    running, end = own.get("lagrange", "u**2"), _ends(own.get("mayer", "x[final]"))
    return f"minimize: {{{entry('integral', running)}, {entry('terminal', end)}}}"


def _control_end(value: Any, path: Path) -> str:
    end = "initial" if path[-1] in ("initial", "start") else "final"
    return f'constraints: {{boundary: [{{expression: "{_name(path)}[{end}]", {entry("equals", value)}}}]}}'


def _periodic(value: Any, path: Path) -> str:
    names = value if isinstance(value, list) and value else ["x"]
    return f'boundary: [{{expression: "{names[0]}[final] - {names[0]}[initial]", equals: 0}}]'


def _jump(value: Any, _: Path) -> str:
    """Of the first state that jumps."""
    name, after = next(iter(value.items()), ("v", "-0.8*v")) if isinstance(value, dict) else ("v", "-0.8*v")
    told = re.sub(rf"\b{re.escape(str(name))}\b(?!\[)", f"a.{name}[final]", str(after))
    condition = f'"b.{name}[initial] = {told}"'
    return f"except: [{name}], and as another entry {condition}, with the names of your phases for a and b"


_ELSEWHERE: dict[tuple[str, str], tuple[str, Line | str]] = {
    ("file", "outputs output observables derived"): ("what is looked at is a named expression", _output),
    ("file", "include includes import imports extends inherit inherits base"): ("a file stands by itself", _INCLUDED),
    ("file", "interp interpolation interpolant interpolants lookup lookup_tables spline splines lut"): (
        "data stand in tables",
        _TABLE,
    ),
    ("file", "dynamics odes ode equations rates derivatives rhs system differential_equations"): (
        "each state has its rate beside it",
        _dynamics,
    ),
    ("file", "minimize minimise maximize maximise"): ("the objective is a section", _terms),
    ("file", "lagrange running_cost"): (
        "the integral of the objective",
        lambda value, _: f"objective: {{minimize: {{{entry('integral', value)}}}}}",
    ),
    ("file", "mayer terminal_cost"): (
        "the terminal term of the objective",
        lambda value, _: f"objective: {{minimize: {{{entry('terminal', _ends(value))}}}}}",
    ),
    ("file", "tf t_f T t_final final_time duration horizon"): (
        "times stand in one section",
        lambda value, _: f"time: {{initial: 0, {entry('final', value)}}}",
    ),
    ("file", "t0 t_0 t_initial initial_time"): (
        "times stand in one section",
        lambda value, _: f"time: {{{entry('initial', value)}, final: 1}}",
    ),
    ("file", "x0 xf ic initial final initial_state final_state initial_conditions final_conditions"): (
        "each state has its ends beside it",
        "states: {x: {rate: v, initial: 0, final: 1}}",
    ),
    ("file", "bounds limits"): ("each variable has its bounds beside it", "controls: {u: {lower: -1, upper: 1}}"),
    ("file", "variables"): ("variables are states or controls", "states: {x: {rate: u}} and controls: {u: {}}"),
    ("file", "method"): (
        "the method belongs to a mesh",
        lambda value, _: f"mesh: [{{{entry('method', value)}, segments: 20}}]",
    ),
    ("file", "segments nodes intervals N n num_segments grid"): (
        "the number of segments belongs to a mesh",
        lambda value, _: f"mesh: [{{method: hermite-simpson, {entry('segments', value)}}}]",
    ),
    ("file", "tolerance tol"): (
        "a tolerance of the error belongs to refinement",
        lambda value, _: f"refine: {{{entry('tolerance', value)}}}",
    ),
    ("state", "guess init initial_guess"): ("guesses stand in one section", _guess),
    ("control", "guess init initial_guess value default"): ("guesses stand in one section", _guess),
    ("control", "initial start"): ("the value of a control at an end is a boundary constraint", _control_end),
    ("control", "final end"): ("the value of a control at an end is a boundary constraint", _control_end),
    ("control", "rate rate_limit slew max_rate"): (
        "to limit how fast a control changes, make it a state, whose rate is a control",
        lambda _, path: (
            f"states: {{{_name(path)}: {{rate: d{_name(path)}}}}} and "
            f"controls: {{d{_name(path)}: {{lower: -1, upper: 1}}}}"
        ),
    ),
    ("state", "free fixed"): ("an end that is left out is free", "initial: 0 or final: 1 for those that are given"),
    ("state", "scale scaling nominal ref"): (
        "sizes stand in one section",
        lambda value, path: f"scaling: {{{entry(_name(path), value)}}} at the left margin",
    ),
    ("time", "free guess lower upper min max"): ("a free time has a range and a guess", _FREE_TIME),
    ("control", "type integer discrete binary"): (
        "every control is a number at every time, not a choice",
        "lower: 0, upper: 1, and look at whether it is at its bounds",
    ),
    ("constraints", "periodic periodicity cyclic"): ("a period is a condition at the ends", _periodic),
    ("guess", "result from"): (
        "an earlier result is given on the command line",
        lambda value, _: f"trajopt solve FILE --guess {value if isinstance(value, str) else 'RESULT.h5'}",
    ),
    ("link", "jump jumps reset resets impact map"): ("a state that jumps does not go on by itself", _jump),
    ("link", "states state continuous continuity"): (
        "all states that both phases have go on",
        "except: [v], with those that do not",
    ),
    ("objective", "lagrange running running_cost integral stage_cost"): (
        "its terms stand under minimize: or maximize:",
        lambda value, _: f"minimize: {{{entry('integral', value)}}}",
    ),
    ("objective", "bolza"): ("its terms stand under minimize: or maximize:", _bolza),
    ("objective", "mayer terminal final end terminal_cost"): (
        "its terms stand under minimize: or maximize:",
        lambda value, _: f"minimize: {{{entry('terminal', _ends(value))}}}",
    ),
}
"""(kind of mapping, words) -> what they are here, and the line that does it."""

_RANGES = frozenset(("bounds", "bound", "range", "limits", "interval"))

_WORDS = {
    (kind, word): key
    for kind, keys in RENAMED.items()
    for key, words in keys.items()
    for word in words.split()
}  # fmt: skip
_LINES = {(kind, word): told for (kind, words), told in _ELSEWHERE.items() for word in words.split()}


def key_wish(path: Path, value: Any) -> Wish | None:
    """What is said of a key that its mapping does not have; None where the word is not known.

    path: of the key.
    value: that was given for it.
    """
    kind, word = kind_of(path[:-1]), str(path[-1])
    if assigned := re.fullmatch(r"(\w+)\s*=\s*(\S.*)", word):  # a = {b: c}, which YAML reads as the key "a = {b"
        return Wish(assigned[1], "an entry has a colon, not =", f"{assigned[1]}: {assigned[2]}: {value}")
    if (kind, word) in _LINES:
        what, line = _LINES[kind, word]
        told = line if isinstance(line, str) else line(value, path)
        section = told.partition(":")[0]
        return Wish(section if kind == "file" and section.isidentifier() else "", what, told)
    if word in _RANGES and "lower" in RENAMED.get(kind, ()):
        ends = value if isinstance(value, list) and len(value) == 2 else [0, 1]
        return Wish("", "", f"{entry('lower', ends[0])}, {entry('upper', ends[1])}")
    if key := _WORDS.get((kind, word)):
        line = entry(key, _ends(value) if key == "terminal" else value)
        if kind == "objective" and isinstance(value, str):
            line = f"{key}: {terms(value)}"
        return Wish(key, "", f"{key}: in place of {word}:" if line == f"{key}:" or kind == "file" else line)
    return _by_value(kind, word, value, path)


def _by_value(kind: str, word: str, value: Any, path: Path) -> Wish | None:
    """What is said of a word that says nothing, by what it is given."""
    if kind == "measured" and isinstance(value, list):
        return Wish("", "columns stand under data", f"data: {{{entry(word, value)}}}, with the others beside it")
    if kind == "guess" and isinstance(value, dict):
        line = f"phases: {{{word}: {{{entry('guess', value)}}}}}"
        return Wish("", "what a phase guesses stands in the phase", line)
    if kind == "guess" and isinstance(value, int | float | list | str) and not isinstance(value, bool):
        return Wish("", "the guess of one variable is of a kind", _guess_of_name(value, path))
    return None


def meant(path: Path, known: Iterable[str]) -> str | None:
    """The key of its mapping that an unknown one stands for: its word here, or the one most like it.

    path: of the unknown key.
    known: the keys that the mapping may have.
    """
    keys, wish = list(known), key_wish(path, None)
    if wish is not None:
        return wish.key if wish.key in keys else None
    return nearest(path[-1], keys)
