"""Lines of a problem file, as messages show them."""

from __future__ import annotations

import re
from typing import Any

import yaml

from ..text import SIDES, compared, shorten, tidy

LONGEST = 60  # letters of a value in a message

NUMBER = r"[-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?"
"""A number of a problem file, as a regular expression."""

_TURNED = {"<": ">", "<=": ">=", ">": "<", ">=": "<="}


class _Dumper(yaml.SafeDumper):
    """Also writes what stands for a mistaken value."""


_Dumper.add_multi_representer(object, lambda dumper, value: dumper.represent_str(getattr(value, "text", "?")))


def flow(value: Any) -> str:
    """A value as YAML on one line, with quotes where it needs them."""
    listed = yaml.dump(
        [value], Dumper=_Dumper, default_flow_style=True, width=float("inf"), sort_keys=False, allow_unicode=True
    )
    quoted = re.sub(r"'([^'\"\\]*)'", r'"\1"', tidy(listed.strip()[1:-1]))
    return re.sub(r"\b(\d+)(?:\.0)?(\.\d+)?e([-+])0?(\d+)\b", r"\1\2e\3\4", quoted).replace("e+", "e")


def entry(key: str, value: Any) -> str:
    """ "key: value", or the key alone where the value is long or nothing."""
    written = flow(value)
    return f"{key}: {written}" if value is not None and len(written) <= LONGEST else f"{key}:"


def condition(text: str) -> dict[str, Any] | None:
    """A comparison as the constraint that says it: "x <= 1" is {expression: x, upper: 1}; None if it is none."""
    sides, signs = compared(text)
    if not all(sides) or len(signs) not in (1, 2):
        return None
    if len(signs) == 2:  # lower <= expression <= upper
        if SIDES[signs[0]] != SIDES[signs[1]] or SIDES[signs[0]] == "equals":
            return None
        lower, expression, upper = sides if SIDES[signs[0]] == "upper" else sides[::-1]
        return {"expression": expression, "lower": plain_value(lower), "upper": plain_value(upper)}
    (left, right), sign = sides, signs[0]
    if re.fullmatch(NUMBER, left):  # 1 >= x
        left, right, sign = right, left, _TURNED.get(sign, sign)
    return {"expression": left, SIDES[sign]: plain_value(right)}


def plain_value(text: str) -> Any:
    """A number where the text is one."""
    if not re.fullmatch(NUMBER, text):
        return shorten(text, LONGEST)
    return int(text) if re.fullmatch(r"[-+]?\d{1,18}", text) else float(text)
