"""Problem files of the tests and of the docs as bases of mutations: loops, vectors, chains, delays, tables, data."""

from __future__ import annotations

import ast
import json
import random
import re
from collections.abc import Iterator
from pathlib import Path

import yaml

from trajopt.problems.errors import TrajoptError
from trajopt.problems.load import load_text

from .mutations import VALUES, Node, at, leaves, shrink

ROOT = Path(__file__).parents[2]
BLOCK = re.compile(r"```yaml\n(.*?)```", re.DOTALL)
MARK = "trajopt: 1"


def bases() -> dict[str, Node]:
    """Name -> data of each text that is a problem file without mistakes, in the order of its place."""
    found = {}
    for place, text in _texts():
        try:
            load_text(text, "x.yaml")
        except TrajoptError:
            continue
        data = yaml.load(text, yaml.CSafeLoader)
        shrink(data)
        found[place] = data
    return found


def _texts() -> Iterator[tuple[str, str]]:
    for path in sorted((ROOT / "tests").rglob("*.py")):
        constants = (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Constant))
        for node in constants:
            if isinstance(node.value, str) and MARK in node.value and len(node.value.splitlines()) > 4:
                yield f"{path.stem}:{node.lineno}", node.value
    for path in [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]:
        yield from ((f"{path.stem}:{k}", f"{MARK}\n{own}") for k, own in enumerate(BLOCK.findall(path.read_text())))


def overrides(data: Node, rng: random.Random) -> list[str]:
    """`--set` of a value of the file, of a part below it, or of nothing in it; in two of three cases none."""
    paths = list(leaves(data))
    if not paths or rng.random() < 2 / 3:
        return []
    path = rng.choice(paths)
    value = rng.choice([at(data, rng.choice(paths)), rng.choice(VALUES)])
    step = rng.choice(["", "", ".m", ".0", ".*", ".value", ".lower", "."])
    written = json.dumps(value, allow_nan=True) if rng.random() < 0.8 else str(value)
    return ["--set", f"{'.'.join(map(str, path))}{step}={written}".replace("\0", "")]
