"""Values that a problem file does not take: how other tools write them, and how they are written here."""

from __future__ import annotations

import re
from collections.abc import Collection
from math import isinf
from typing import Any

from ..yaml.document import Path, in_words, scalar
from ..yaml.punctuation import comma_in_number, ends_of_range
from .keys import terms
from .lines import NUMBER, condition, entry, flow, plain_value

Words = tuple[str, str]
"""What is wrong, and the remedy."""

_QUANTITY = re.compile(rf"({NUMBER})\s*((?:[A-Za-zµμ°Ω%][\w µμ°Ω*/^.·²³-]*))")
_DEGREES = re.compile(r"°|deg|degs|degree|degrees")
_RESULT, _CSV = re.compile(r"\S+\.(h5|hdf5|nc)"), re.compile(r"\S+\.csv")
_ASSIGNED = re.compile(r"[\w./()']+\s*=\s*([^=].*)")

LONGEST = 300
"""Characters of a slip: what is longer is none, and would take its time to look through."""

_SIDES = ("lower", "upper")
ENDLESS = ["inf", "Inf", "INF", "infinity", "Infinity", "oo"]
"""Words for an end that is none."""

METHODS = {
    "hermite-simpson": "hs hermite simpson hermitesimpson separated-hermite-simpson",
    "hermite-simpson-compressed": "compressed compressed-hermite-simpson hsc",
    "trapezoid": "trapz trap trapezium tz crank-nicolson",
    "runge-kutta-4": "rk4 rk runge-kutta shooting multiple-shooting single-shooting ms ss",
    "dormand-prince": "rk45 dopri5 dopri ode45 rk5",
    "radau": "lgr flipped-lgr legendre-gauss-radau radau-iia pseudospectral gpops gpops-ii collocation",
    "gauss": "lg legendre-gauss legendre gpm gauss-legendre",
    "lobatto": "lgl legendre-gauss-lobatto gauss-lobatto",
    "chebyshev": "cgl chebyshev-gauss-lobatto",
    "explicit-euler": "euler forward-euler",
    "implicit-euler": "backward-euler",
}
"""Method -> its names elsewhere, in lower case, with - between words."""

_METHODS = {word: method for method, words in METHODS.items() for word in words.split()}


def method_meant(word: str, known: Collection[str]) -> str | None:
    """The method that goes by another name elsewhere, if it is known here."""
    plain_word = re.sub(r"[\s_]+", "-", word.strip().lower())
    method = plain_word if plain_word in known else _METHODS.get(plain_word)
    return method if method in known else None


def value_wish(path: Path, given: Any) -> Words | None:
    """What is said of a value that cannot stand at a path; None where nothing is known of it.

    path: of the value; it may go on into a long form that the file does not have.
    given: the value.
    """
    if isinstance(given, str) and len(given) > LONGEST:
        return None
    if path[-1:] in (("value",), ("expression",)) and not (isinstance(given, str) and _ASSIGNED.fullmatch(given)):
        path = path[:-1]
    if not path:
        return None
    if len(path) > 2 and path[0] == "phases":
        path = path[2:]
    found = (
        _end(path, given)
        or _not_a_value(path, given)
        or _section(path, given)
        or _table(path, given)
        or _entry(path, given)
        or _constraint(path, given)
    )
    return found or (_text(path, given) if isinstance(given, str) else None)


def _end(path: Path, given: Any) -> Words | None:
    """What is said of an end or of a bound: a range in brackets, or that there is none."""
    key = str(path[-1])
    if key in ("initial", "final") and isinstance(given, list) and len(given) == 2:
        limits = [entry(side, end) for side, end in zip(("lower", "upper"), given, strict=True) if not _endless(end)]
        range_ = f"write {key}: {{{', '.join(limits)}}}"
        return "a range is no list", range_ if limits else leave_out(path)
    if key in ("initial", "final") and isinstance(given, str) and (ends := ends_of_range(given)):
        return _end(path, list(map(scalar, ends)))
    if key in ("initial", "final") and isinstance(given, str) and (limit := condition(f"x {given}")):
        return "an end has a range", f"write {key}: {flow({side: limit[side] for side in limit if side in _SIDES})}"
    return None


def _not_a_value(path: Path, given: Any) -> Words | None:
    """What is said of yes, no and infinity."""
    key = str(path[-1])
    if isinstance(given, bool) and path[0] in ("states", "controls", "algebraic", "optimize", "time"):
        return f"{key} is {in_words(given)}", f"write its value, such as {key}: 1" if given else leave_out(path)
    if isinstance(given, float) and isinf(given) and key in ("lower", "upper"):
        return "this is infinite, or a number above 1e308", leave_out(path)
    return None


def _endless(end: object) -> bool:
    """Whether an end of a range is none."""
    return (isinstance(end, float) and isinf(end)) or (isinstance(end, str) and end.lstrip("+-") in ENDLESS)


def leave_out(path: Path) -> str:
    """The remedy where nothing should be given: the key is left out."""
    key = str(path[-1]) if path[-1] != "value" else str(path[-2])
    if path[0] == "time" and path[-2:-1] in (("initial",), ("final",)) and key in ("lower", "upper"):
        return f"a free time has a range and a guess: write {key}: {'0.1' if key == 'lower' else '10, guess: 1'}"
    if path[0] == "time":
        return f"a free time has a range and a guess: write {key}: {{lower: 0.1, upper: 10, guess: 1}}"
    return f"leave {key}: out" + (" for no bound" if key in ("lower", "upper") else ", for what is not given is free")


def _table(path: Path, given: Any) -> Words | None:
    """A table that is the name of its file, and points without that of their argument."""
    match path:
        case ("tables", name) if isinstance(given, str) and _CSV.fullmatch(given):
            return "the columns of a CSV file are a table by a key of it", f"write {name}: {{file: {given}}}"
        case ("tables", _, "points") if isinstance(given, list) and given:
            line = entry("points", {"x": given})
            return "points are of an argument, by its name", f"write {line}, with its name for x"
    return None


def _section(path: Path, given: Any) -> Words | None:
    """A section that has another form."""
    number = isinstance(given, int | float) and not isinstance(given, bool)
    text, items = isinstance(given, str), given if isinstance(given, list) else []
    wish: Words | None = None
    match path:
        case ("objective",) if text:
            wish = "the objective says minimize or maximize", f"write objective: {{minimize: {terms(given)}}}"
        case ("objective", "minimize" | "maximize" as sense) if text:
            wish = "the objective has terms, an integral and a terminal one", f"write {sense}: {terms(given)}"
        case ("time",) if number or len(items) == 2:
            first, last = items or (0, given)
            wish = "time has two ends", f"write time: {{{entry('initial', first)}, {entry('final', last)}}}"
        case ("states",) if items and all(isinstance(name, str) for name in items):
            rates = ", ".join(f"{name}: {{rate: ...}}" for name in items[:3])
            wish = "each state is told with its rate", f"write states: {{{rates}}}"
        case ("controls",) if text or items:
            names = [given] if text else [name for name in items if isinstance(name, str)]
            inner = ", ".join(f"{name}: {{}}" for name in names[:3]) or "u: {}"
            wish = "controls are told by name", f"write controls: {{{inner}}}"
        case ("refine",) if number:
            wish = "refinement has several settings", f"write refine: {{{entry('tolerance', given)}}}"
        case ("guess",) if text and _CSV.fullmatch(given):
            wish = "the columns of a CSV file are one of several kinds of guess", f"write guess: {{file: {given}}}"
        case ("guess",) if text:
            wish = result_as_guess(given)
    return wish


def _entry(path: Path, given: Any) -> Words | None:
    """An entry of a section that has another form."""
    match path:
        case ("states", name) if isinstance(given, str) and (state := _of_rate(str(name))):
            return f"the rate of {state} stands beside it", f"write {state}: {{{entry('rate', given)}}}"
        case ("states", name) if isinstance(given, str) and re.fullmatch(r"[A-Za-z]\w*", str(name)):
            return "a state has its rate, its ends and its bounds", f"write {name}: {{{entry('rate', given)}}}"
        case ("tables", name) if isinstance(given, list) and _pairs(given):
            points, values = zip(*given, strict=True)
            line = f"{name}: {{points: {{x: {flow(list(points))}}}, {entry('values', list(values))}}}"
            return "a table has points and values", f"write {line}, with the name of its argument for x"
        case ("objective", sense, "integral" | "terminal" as term) if isinstance(given, dict) and given:
            phase, value = next(iter(given.items()))
            line = entry("objective", {sense: {term: value}})
            return "the terms of a phase stand in it", f"under phases.{phase} write {line}"
        case ("continuation", name) if isinstance(given, int | float) and not isinstance(given, bool):
            return "the values on the way are a list", f"write {name}: [{given}]"
    return None


def _of_rate(name: str) -> str | None:
    """x, where a name is that of its rate: x_dot, xdot, dx, dxdt, x'."""
    rate = re.fullmatch(r"(\w+?)_?dot|d([A-Za-z]\w*?)(?:_?dt)?|d(\w+)/dt|(\w+)'", name)
    return next(filter(None, rate.groups()), None) if rate else None


def _pairs(items: list[Any]) -> bool:
    """Whether a list is one of pairs of numbers."""
    pairs = [item for item in items if isinstance(item, list) and len(item) == 2]
    return len(items) > 1 and len(pairs) == len(items)


def result_as_guess(file: str) -> Words | None:
    """What is said of a result file that is named as a guess; None for other names."""
    if not _RESULT.fullmatch(file):
        return None
    return "an earlier result is given on the command line", f"write trajopt solve FILE --guess {file}"


def _constraint(path: Path, given: Any) -> Words | None:
    """A constraint as a comparison, alone or as the first of a list."""
    first = given[0] if isinstance(given, list) and given else given
    limit = condition(first) if isinstance(first, str) else None
    if path[:1] != ("constraints",) or limit is None:
        return None
    if len(path) == 1:
        kind = "boundary" if "[" in first else "path"
        return "constraints have a kind", f"write constraints: {{{kind}: [{flow(limit)}]}}"
    what = "a constraint is told by its parts"
    if path[-1] == "expression":
        return what, f"write {flow(limit)[1:-1]}"
    if len(path) == 2:
        return what, f"write {path[1]}: [{flow(limit)}]"
    return (what, f"write {flow(limit)}") if isinstance(path[-1], int) else None


def _text(path: Path, given: str) -> Words | None:
    """A text where a number or an expression is meant."""
    text, key = given.strip(), str(path[-1])
    if key in ("rate", "accel") and (assigned := _ASSIGNED.fullmatch(text)):
        return f"the {key} is what stands to the right of =", f"write {entry(key, plain_value(assigned[1]))}"
    if key in ("rate", "accel", "expression", "integral", "terminal"):
        return None
    quantity = _QUANTITY.fullmatch(text)
    with_unit = _with_unit(path, quantity[1], quantity[2].strip(), " " in text) if quantity else None
    return _digits(key, text) or with_unit


def _digits(key: str, text: str) -> Words | None:
    """A number as other languages and other people write it."""
    if comma := re.fullmatch(r"([-+]?\d{1,3}),(\d+)", text):
        return comma_in_number(key, comma[1], comma[2])
    if exponent := re.fullmatch(r"([-+]?[\d.]+)[dD]([-+]?\d+)", text):
        return "the exponent of a number is written with e", f"write {key}: {exponent[1]}e{exponent[2]}"
    if re.fullmatch(r"[-+]?\d[\d_.]*_[\d_.]+(e[-+]?\d+)?", text):
        return "there is no _ in a number", f"write {key}: {text.replace('_', '')}"
    if re.fullmatch(r"[-+]?\d{1,3}('\d{3})+(\.\d*)?", text):
        return "there are no marks in a number", f"write {key}: {text.replace(chr(39), '')}"
    return None


def _with_unit(path: Path, value: str, unit: str, apart: bool) -> Words | None:
    """A number and what follows it, with a space between them or without one."""
    key, named = path[-1], path[0] in ("parameters", "expressions")
    if unit == "%":
        return "a percentage is a number", f"write {key}: {float(value) / 100:g}"
    if _DEGREES.fullmatch(unit):
        return "an angle is in radians", f"write {key}: {value}*pi/180"
    product = not apart and not named and re.fullmatch(r"[A-Za-z_]\w*", unit)  # 2x, without its operator
    if not unit or product or re.match(r"[eEdD][-+]?\d", unit):
        return None
    if named:
        return "a value has its unit beside it", f"write {key}: {{value: {value}, {entry('unit', unit)}}}"
    return "units stand in unit:, not in the value", f"write {key}: {value}"
