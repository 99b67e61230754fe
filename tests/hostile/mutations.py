"""Mutations of problem files: of the values, of the expressions, of the keys, and of the text."""

from __future__ import annotations

import copy
import random
import re
from collections.abc import Callable, Iterator
from typing import Any

import yaml

from trajopt.problems.catalog import shipped
from trajopt.problems.expressions.functions import FUNCTIONS

Node = dict[str, Any] | list[Any]

CONTROLS = ["\x00", "\x07", "\x1b[31mred", "\x1b]0;x\x07", "\x9b2J", "\x7f", "\u202e", "\u2028", "\ufeff", "\r", "\t"]
VALUES: list[Any] = [
    None, True, False, 0, 1, -1, 2, 0.5, -0.0, 1e-12, 1e3, 1e6, 200_000, 200_001, 2**53 + 1, 10**30, 1e308, -1e308,
    1e-320, float("nan"), float("inf"), float("-inf"), "", " ", "x", "t", "final", "pi", "no", "1e400", "0/1", "1/0",
    "sqrt(-1)", "abs(t)", "t - t", "0*t", "max(t, 1)", "[initial]", "2024-01-01", "12:30", "é", "日本語", "x" * 20_000,
    "(" * 60 + "1" + ")" * 60, "auto", "none", "linear", [], {}, [1], [None], [[[]]], {"a": 1},
    {"lower": 1, "upper": 0}, {"value": "nan"}, [float("nan")] * 3, *(f"a{c}b" for c in CONTROLS),
]  # fmt: skip
"""What a value of a problem file becomes."""

LONG = {
    "sum": lambda name, k: " + ".join([name] * k),
    "product": lambda name, k: "*".join(f"({name} + {i})" for i in range(k)),
    "cosines": lambda name, k: "*".join(f"cos({i}*{name})" for i in range(1, k + 1)),
    "quotients": lambda name, k: "/".join(f"({name} + {i})" for i in range(1, k + 1)),
    "nest": lambda name, k: "sin(" * min(k, 45) + name + ")" * min(k, 45),
    "powers": lambda name, k: f"({name})" + "**2" * 1 + "".join(f" + {name}**{i}" for i in range(3, k)),
    "tower": lambda name, k: "**".join([name, *["1.5"] * min(k, 30)]),
}  # fmt: skip
"""Long expressions of a name, of some k terms."""

TOKEN = re.compile(r"[A-Za-z_]\w*|\d+\.?\d*(?:[eE][-+]?\d+)?|\*\*|[-+*/()\[\],]")
MAX_LENGTH = 3990  # characters of an expression


def bases() -> dict[str, Node]:
    """The shipped files as plain data, on meshes of 3 segments at most, and all sections of a rare kind among them."""
    found = {}
    for name, path in sorted(shipped().items()):
        data = yaml.load(path.read_text(), yaml.CSafeLoader)
        shrink(data)
        found[name] = data
    return found


def shrink(data: Node) -> None:
    """Meshes of 3 segments; numbers are texts to PyYAML in some forms (1e-8), which is right here."""
    phases = data.get("phases")
    parts = [data, *(phases.values() if isinstance(phases, dict) else ())]
    meshes = [part.get("mesh") for part in parts if isinstance(part, dict)]
    for entry in (entry for mesh in meshes if isinstance(mesh, list) for entry in mesh if isinstance(entry, dict)):
        if isinstance(entry.get("segments"), int) and not isinstance(entry.get("degree"), list):
            entry["segments"] = min(entry["segments"], 3)


def leaves(node: Any, path: tuple = ()) -> Iterator[tuple]:
    """The path of every value, of mappings and lists too."""
    items = node.items() if isinstance(node, dict) else enumerate(node) if isinstance(node, list) else ()
    for key, value in items:
        yield (*path, key)
        yield from leaves(value, (*path, key))


def at(node: Any, path: tuple) -> Any:
    for key in path:
        node = node[key]
    return node


def mutated(data: Node, others: list[Node], rng: random.Random) -> Node:
    """A copy with one to four mutations; a part may come from one of the others."""
    data = copy.deepcopy(data)
    for _ in range(rng.choice([1, 1, 1, 2, 2, 4])):
        paths = list(leaves(data))
        if not paths:
            break
        rng.choice(MUTATIONS)(data, rng.choice(paths), rng, others)
    return data


def _replace(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    at(data, path[:-1])[path[-1]] = rng.choice(VALUES)


def _delete(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    del at(data, path[:-1])[path[-1]]


def _duplicate(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    parent, value = at(data, path[:-1]), copy.deepcopy(at(data, path))
    if isinstance(parent, list):
        parent.insert(rng.randint(0, len(parent)), value)
    else:
        parent[f"{path[-1]}{rng.choice(['2', '_', 'é', ' ', '.a', ''])}"] = value


def _swap(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    other = rng.choice(list(leaves(data)))
    if path[: len(other)] == other or other[: len(path)] == path:
        return
    mine, its = at(data, path), at(data, other)
    at(data, path[:-1])[path[-1]], at(data, other[:-1])[other[-1]] = its, mine


def _rename(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    parent = at(data, path[:-1])
    if isinstance(parent, dict):
        keys = [key for own in leaves(data) for key in own[-1:] if isinstance(key, str)]
        new = rng.choice([rng.choice(keys), "x" * 70, "t", "final", "a b", "a-b", "é", "1", *CONTROLS, "phases", ""])
        items = [(new if key == path[-1] else key, value) for key, value in parent.items()]
        parent.clear()
        parent.update(items)


def _graft(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    """A part of another file, under its own key."""
    other = rng.choice(others)
    place = rng.choice(list(leaves(other)))
    target = at(data, place[:-1]) if _has(data, place[:-1]) else data
    if isinstance(target, dict) and isinstance(place[-1], str):
        target[place[-1]] = copy.deepcopy(at(other, place))


def _has(data: Any, path: tuple) -> bool:
    try:
        at(data, path)
    except (KeyError, IndexError, TypeError):
        return False
    return True


def _wrap(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    value = at(data, path)
    at(data, path[:-1])[path[-1]] = rng.choice(
        [[value], {path[-1]: value}, {"value": value}, [value, value], str(value)]
    )


def _number(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    numbers = [own for own in leaves(data) if isinstance(at(data, own), int | float)]
    if numbers:
        own = rng.choice(numbers)
        at(data, own[:-1])[own[-1]] *= rng.choice([-1, 0, 1e-9, 0.1, 10, 1e9, 1e300])


def _expression(data: Node, path: tuple, rng: random.Random, others: list[Node]) -> None:
    texts = [
        own for own in leaves(data) if isinstance(at(data, own), str) and own[-1] not in ("note", "source", "name")
    ]
    if texts:
        own = rng.choice(texts)
        names = [key for found in leaves(data) for key in found[-1:] if isinstance(key, str)]
        at(data, own[:-1])[own[-1]] = rng.choice(EXPRESSIONS)(at(data, own), names, rng)


def _token(text: str, names: list[str], rng: random.Random) -> str:
    found = list(TOKEN.finditer(text))
    if not found:
        return text
    own = rng.choice(found)
    kinds = {
        "name": [*names, "pi", "t"],
        "number": ["0", "1", "1e99", "1e101", "0.5", "-1"],
        "operator": list("+-*/,()"),
    }
    kind = "name" if own[0][0].isalpha() else "number" if own[0][0].isdigit() else "operator"
    other = "" if rng.random() < 0.15 else rng.choice(kinds[kind if rng.random() < 0.85 else rng.choice(list(kinds))])
    return text[: own.start()] + str(other) + text[own.end() :]


def _in_function(text: str, names: list[str], rng: random.Random) -> str:
    function = rng.choice(list(FUNCTIONS))
    return rng.choice([f"{function}({text})", f"{function}({text}, 0.1)", f"{text} + {function}({rng.choice(names)})"])


def _constant(text: str, names: list[str], rng: random.Random) -> str:
    return rng.choice(["1", "0", "pi", f"0*({text})", f"({text}) - ({text})", f"({text})**0", f"1e90*({text})"])


def _long(text: str, names: list[str], rng: random.Random) -> str:
    name = rng.choice([*(own for own in TOKEN.findall(text) if own.isidentifier()), "t"])
    made = LONG[rng.choice(list(LONG))](name, rng.choice([10, 30, 100, 300, 1000]))
    return made if len(made) < MAX_LENGTH else text


EXPRESSIONS: list[Callable[[str, list[str], random.Random], str]] = [_token, _token, _in_function, _constant, _long]
MUTATIONS: list[Callable[[Node, tuple, random.Random, list[Node]], None]] = [
    _replace, _replace, _delete, _delete, _duplicate, _swap, _rename, _graft, _graft, _wrap, _number, _number,
    _expression, _expression, _expression, _expression,
]  # fmt: skip


def as_text(data: Node, rng: random.Random) -> str:
    """The YAML of the data, in one of its styles; in one of ten the text is damaged, too."""
    style = rng.choice([None, None, True, False])
    text = yaml.dump(data, Dumper=_Dumper, default_flow_style=style, allow_unicode=rng.random() < 0.5, sort_keys=False)
    return _damaged(text, rng) if rng.random() < 0.1 else text


class _Dumper(yaml.SafeDumper):
    def ignore_aliases(self, data: Any) -> bool:
        return True


PIECES = [*CONTROLS, ":", "-", "'", '"', "&a ", "*a ", "!!python/name:os.system ", "#", "%", "|", "\n"]


def _damaged(text: str, rng: random.Random) -> str:
    lines, place = text.splitlines(keepends=True), rng.randrange(len(text))
    k = rng.randrange(len(lines))
    line = rng.choice(["", lines[k] * 2, f"  {lines[k]}"])
    of_lines = "".join([*lines[:k], line, *lines[k + 1 :]])
    inserted = text[:place] + rng.choice(PIECES) + text[place:]
    return rng.choice([of_lines, of_lines, inserted, inserted, text[:place], text[:place] + text[place + 1 :]])
