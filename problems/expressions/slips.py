"""What an expression may look like, read token by token before Python's parser sees it.

Nothing is evaluated here. Every slip that people make often (`^`, `2x`, `ln`, `np.sin`, a comparison, a missing
parenthesis) gets a message of its own, which Python's "invalid syntax" could not give.
"""

from __future__ import annotations

import keyword
import re
from collections.abc import Collection
from itertools import pairwise

from ..text import did_you_mean, named, nearest, shorten
from .delays import is_earlier
from .functions import FUNCTIONS, may_hold_commas, smooth_names
from .lacking import ALIASES, LACKING, at_another_time, end_meant
from .tokens import DEGREES, ExpressionError, Token, check_number, closing, fail, head_of, tokens_of

ENDS = ("initial", "final")
DURATION = "duration"  # t[duration]: t[final] - t[initial]
RATE = "rate"  # v[rate]: the time derivative of a state whose dynamics are implicit
# `time` heads the keyframes of a guess, so no state may be called that.
RESERVED = frozenset({"t", "time", "pi", *ENDS, *FUNCTIONS, *keyword.kwlist})

MODULES = frozenset(["np", "numpy", "math", "cmath", "scipy", "sp", "sympy", "casadi", "ca", "jnp", "torch", "self"])
"""What stands before a point in the expressions of other tools; here it is the name of a phase."""

MAX_LENGTH = 4000  # characters
MAX_NAME = 60
MAX_PARENTHESES = 50  # parentheses inside parentheses
MAX_SIGNS = 3  # signs in a row: a - -b is arithmetic, a ---- b a typing mistake
MAX_NUMBER = 1e100
MAX_EXPONENT = 1000

_BRANCHES = ("if", "else", "and", "or", "not")
_COMPARISON = (
    "an expression is one value, not a comparison",
    "give the bounds as lower:, upper: or equals: beside it, or write a smooth switch as step(x - a, eps)",
)
_STRAY = ("this character has no meaning in an expression", "use names, numbers, + - * / ** and parentheses")
_QUOTE = ("this quotation mark is a typographic one, which YAML takes for a letter", 'write a plain "')
_OTHER = {
    "^": ("^ is not the power operator", "write ** for a power, as in x**2"),
    "=": _COMPARISON,
    "<": _COMPARISON,
    ">": _COMPARISON,
    "!": ("! has no meaning in an expression", "write a factorial as a number, a comparison as lower: or upper:"),
    "{": ("braces are not used in expressions", "write ( ) instead"),
    "}": ("braces are not used in expressions", "write ( ) instead"),
    "%": ("% has no meaning in an expression", "write a percentage as a number, for example 0.05"),
    "#": ("# would start a comment inside the expression", "move the comment out of the expression"),
    "π": ("π is not a name", "write pi"),
    "²": ("superscripts are not read", "write **2"),
    "³": ("superscripts are not read", "write **3"),
    "×": ("× is not an operator", "write *"),
    "·": ("· is not an operator", "write *"),
    "−": ("this minus sign is a typographic one", "write a plain -"),
    "–": ("this minus sign is a typographic one", "write a plain -"),
    "“": _QUOTE,
    "”": _QUOTE,
    "„": _QUOTE,
    "‘": _QUOTE,
    "’": _QUOTE,
    "'": ("an apostrophe has no meaning in an expression", "write digits without marks, and a text in plain quotes"),
    "√": ("√ is not a function", "write sqrt( )"),
    "°": ("angles are in radians", "write 30*pi/180 for 30 degrees"),
}


def _other(character: str) -> tuple[str, str]:
    """What is said of a character that no expression has; one that cannot be seen is named."""
    if character.isprintable() or character in _OTHER:
        return _OTHER.get(character, _STRAY)
    return f"there is an invisible character here, {named(character)}", "remove it"


def check_syntax(text: str, called: Collection[str] = ()) -> None:
    """Raise ExpressionError for the first slip in a tidy text; say nothing about a text that may be an expression.

    text: the expression.
    called: the names that have arguments: of tables of data, and of functions of the file.
    """
    if not text:
        raise ExpressionError("the expression is empty", "write a number or an expression such as m*g*sin(q)")
    if len(text) > MAX_LENGTH:
        raise ExpressionError(
            f"the expression has {len(text)} characters, more than the {MAX_LENGTH} allowed",
            "name its parts under expressions:",
        )
    tokens = _with_called(text, tokens_of(text), called)
    for token, after in pairwise(tokens):
        _check_token(text, token, after)
    _check_brackets(text, tokens)
    tokens = _separated(tokens)
    for before, token, after in zip(tokens, tokens[1:], [*tokens[2:], tokens[-1]], strict=False):
        _check_neighbours(text, before, token, after)
    _check_signs(text, tokens)


def _with_called(text: str, tokens: list[Token], called: Collection[str]) -> list[Token]:
    """The tokens with names marked that stand before arguments: of tables, of functions of the file, and of states at
    an earlier time.

    A name before arguments that is nearly one of them is refused.
    """
    marked = tokens[:]
    for i, (token, after) in enumerate(pairwise(tokens)):
        if token.category != "name" or after.text != "(" or token.text in FUNCTIONS:
            continue
        if token.text in called or (token.text not in (*LACKING, *ALIASES) and _is_delay(text, after)):
            marked[i] = token._replace(category="called")
        elif token.text not in (*LACKING, *ALIASES) and (meant := did_you_mean(token.text, called)):
            fail(text, token, token, f"there is no {token.text}(...)", meant)
    return marked


def _is_delay(text: str, bracket: Token) -> bool:
    """Whether what a name is called with is an earlier time: x(t - tau)."""
    return is_earlier(text[bracket.stop : closing(text, bracket).start])


def _check_token(text: str, token: Token, after: Token) -> None:
    # before a comparison in its arguments is told to be one
    if token.text in LACKING and after.text == "(":
        fail(text, token, closing(text, after), *LACKING[token.text])
    if token.category == "other":
        if token.text == "°" and (angle := re.search(r"([\w.]+)\s*$", text[: token.start])):
            first = Token("number", angle[1], angle.start(), angle.end())
            fail(text, first, token, "angles are in radians", f"write {angle[1]}*pi/180")
        fail(text, token, token, *_other(token.text))
    if token.text == "//":
        fail(text, token, token, "// is not an operator", "write / for a division")
    if token.category == "name" and keyword.iskeyword(token.text):
        fail(
            text,
            token,
            token,
            f"{token.text} is a word of Python, not of expressions, which have no branches",
            LACKING["if"].remedy
            if token.text in _BRANCHES
            else "use names, numbers, + - * / ** and the functions " + " ".join(smooth_names()),
        )
    if token.category == "name" and token.text.split(".")[0] in MODULES and "." in token.text:
        fail(text, token, token, *_no_module(token.text.split(".")[1]))
    if max(map(len, token.text.split("."))) > MAX_NAME:
        fail(text, token, token, f"this is longer than {MAX_NAME} characters", "shorten it")
    if token.category == "number" and float(token.text) > MAX_NUMBER:
        fail(text, token, token, f"the number is larger than {MAX_NUMBER:g}", "choose units in which it is smaller")


def _check_brackets(text: str, tokens: list[Token]) -> None:
    opened: list[Token] = []
    for token in tokens:
        if token.text in ("(", "["):
            opened.append(token)
        elif token.text in (")", "]"):
            if not opened:
                fail(text, token, token, f"{token.text} closes nothing", f"remove it or open it before: {text}")
            opener = opened.pop()
            if opener.text + token.text not in ("()", "[]"):
                fail(text, opener, token, f"{opener.text} is closed by {token.text}", "use the matching bracket")
        if len(opened) > MAX_PARENTHESES:
            raise ExpressionError(
                f"parentheses are nested deeper than {MAX_PARENTHESES}", "name the inner parts under expressions:"
            )
    if opened:
        close = ")" if opened[-1].text == "(" else "]"
        fail(text, opened[-1], tokens[-1], f"{opened[-1].text} is never closed", f"add the missing {close}")


def _separated(tokens: list[Token]) -> list[Token]:
    """The tokens with the commas between the arguments of functions marked as separators."""
    openers, marked = [], []
    for before, token in zip([tokens[0], *tokens], tokens, strict=False):
        if token.text in ("(", "["):
            openers.append(token.text == "(" and (before.category == "called" or may_hold_commas(before.text)))
        elif token.text in (")", "]"):
            openers.pop()
        separates = token.text == "," and openers and openers[-1]
        marked.append(token._replace(category="separator") if separates else token)
    return marked


def _check_signs(text: str, tokens: list[Token]) -> None:
    run: list[Token] = []
    for token in tokens:
        run = [*run, token] if token.text in ("+", "-") else []
        if len(run) > MAX_SIGNS:
            fail(text, run[0], token, "too many signs in a row", "write one sign")


def _check_neighbours(text: str, before: Token, token: Token, after: Token) -> None:
    """The rules that need a token and the ones beside it: `before` has been checked, `token` is next."""
    if token.text == ".":
        _check_dot(text, before, token, after)
    elif token.text == "," and token.category != "separator":
        remedy = "write 0.5, not 0,5, and give a function one argument"
        fail(text, before, after, "a comma has no meaning here", remedy)
    elif token.text == "[":
        _check_subscript(text, before, token, after)
    elif _ends_operand(before) and _starts_operand(token):
        _check_adjacent(text, before, token, after)
    elif before.text in FUNCTIONS:
        fail(text, before, before, f"{before.text} has no argument", f"write {before.text}(...)")
    elif not _ends_operand(before) and not _starts_operand(token) and token.text not in ("+", "-"):
        _check_missing(text, before, token)


def _ends_operand(token: Token) -> bool:
    return token.category in ("number", "name") or token.text in (")", "]")


def _starts_operand(token: Token) -> bool:
    return token.category in ("number", "name", "called") or token.text == "("


def _check_dot(text: str, before: Token, dot: Token, after: Token) -> None:
    if before.category == "name" and after.category == "name":
        fail(text, before, after, *_no_module(after.text))
    fail(text, before, after, "this point belongs to no number", "write a number as 0.5")


def _no_module(name: str) -> tuple[str, str]:
    remedy = f"write {name}" if name in smooth_names() or name == "pi" else "write a plain name"
    return "expressions know no modules and no attributes", remedy


def _check_subscript(text: str, before: Token, bracket: Token, after: Token) -> None:
    close = text.find("]", bracket.start)
    inside = text[bracket.stop : close].strip()
    if before.category != "name":
        remedy = "write ( ) to group, and an end of time after each name in it: x[final]"
        fail(text, bracket, after, "[ ] stands after a name only", remedy)
    if inside == DURATION and before.text.rpartition(".")[2] == "t":
        return
    if inside not in (*ENDS, RATE):
        last = Token("operator", "]", close, close + 1)
        if before.text != "t" and (end := end_meant(inside)):
            component = f"; for a component make {before.text} a vector, by size: 3" if inside.isdigit() else ""
            remedy = f"write {end.format(before.text)}{component}"
            fail(text, before, last, "an end of time is called initial or final", remedy)
        if lack := at_another_time(before.text, inside):
            fail(text, before, last, *lack)
        if inside == DURATION:
            fail(text, before, last, "only the time has a duration: t[duration]", f"write {before.text}[final]")
        what = "[ ] only marks the value at an end of time, or the rate of an implicit state"
        fail(text, before, last, what, f"write {before.text}[initial] or {before.text}[final]")


def _check_adjacent(text: str, before: Token, token: Token, after: Token) -> None:
    """Two operands side by side: a call, or a missing operator."""
    if token.text == "(" and before.category == "name":
        if before.text not in FUNCTIONS:
            _check_call(text, before, token)
        return
    if before.text in FUNCTIONS:
        argument = token.text if token.category != "number" or after.category != "name" else token.text + after.text
        fail(text, before, token, f"{before.text} needs parentheses", f"write {before.text}({argument})")
    if before.category == "number" and token.category == "name":
        check_number(text, before, token)
    if token.text in DEGREES:
        fail(text, before, token, "angles are in radians", f"write {head_of(before)}*pi/180")
    if (before.category, token.category) == ("number", "number") and re.fullmatch(r"\d{3}", token.text):
        fail(text, before, token, "there is no space in a number", f"write {before.text}{token.text}")
    tail = "(...)" if token.text == "(" else token.text
    if token.category in ("name", "called") and after.text == "(":
        tail = f"{token.text}(...)"
    product = f"write {head_of(before)}*{tail} for a product"
    fail(text, before, token, "an operator is missing between them", product)


def _check_call(text: str, name: Token, bracket: Token) -> None:
    """A call of something that is not one of the functions."""
    last = closing(text, bracket)
    argument = shorten(text[bracket.stop : last.start].strip(), 40)
    if name.text in ALIASES:
        remedy = f"write {ALIASES[name.text].format(argument)}"
        fail(text, name, last, f"there is no function {name.text}", remedy)
    if lack := at_another_time(name.text, argument):
        fail(text, name, last, *lack)
    if nearest(name.text, FUNCTIONS):
        fail(text, name, last, f"there is no function {name.text}", did_you_mean(name.text, FUNCTIONS))
    known = f"the functions are {' '.join(smooth_names())}"
    fail(text, name, last, f"{name.text} is not a function", f"write {name.text}*(...) for a product; {known}")


def _check_missing(text: str, before: Token, token: Token) -> None:
    """An operator without its operand."""
    if before.category == "end":
        fail(text, token, token, f"the expression starts with {token.text}", "write what stands before it")
    if token.category == "end":
        fail(text, before, before, f"the expression ends with {before.text}", "write what stands after it")
    if before.text + token.text == "()":
        fail(text, before, token, "there is nothing between the parentheses", "write a value between them")
    fail(text, before, token, f"a value is missing between {before.text} and {token.text}", "write it or remove one")
