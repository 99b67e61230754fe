"""Imports point one way: cli -> results -> transcription -> problems."""

import ast
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("problems", "transcription", "results", "cli")
FILES = [path for layer in LAYERS for path in sorted((ROOT / layer).rglob("*.py"))]


def imported_layers(path: Path) -> set[str]:
    """The layers that a file imports, at its top or inside functions."""
    package = path.relative_to(ROOT).parent.parts
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ["trajopt", *package][: len(package) + 2 - node.level] if node.level else []
            names = [".".join([*base, *filter(None, [node.module])])]
            names += [f"{names[0]}.{alias.name}" for alias in node.names]
        else:
            continue
        parts = [name.split(".") for name in names]
        found |= {p[1] for p in parts if p[0] == "trajopt" and len(p) > 1 and p[1] in LAYERS}
    return found


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_no_import_points_up(path):
    own = LAYERS.index(path.relative_to(ROOT).parts[0])
    above = {layer for layer in imported_layers(path) if LAYERS.index(layer) > own}
    assert not above


def test_the_check_sees_relative_and_absolute_imports():
    assert imported_layers(ROOT / "cli" / "common.py") >= {"problems", "transcription"}
    assert imported_layers(ROOT / "transcription" / "collocation.py") >= {"problems", "transcription"}


@pytest.mark.parametrize("path", [f for f in FILES if f.parent.name != "cli"], ids=lambda p: str(p.relative_to(ROOT)))
def test_nothing_below_the_command_line_prints_or_exits(path):
    calls = [node.func for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.Call)]
    assert not [call.id for call in calls if isinstance(call, ast.Name) and call.id in ("print", "exit", "quit")]
