"""Imports point one way: cli -> results -> transcription -> problems."""

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent
LAYERS = ("problems", "transcription", "results", "cli")
FORBIDDEN = {
    *("print", "input", "exit", "quit", "SystemExit"),
    *("sys.exit", "sys.stdout", "sys.stderr", "sys.__stdout__", "sys.__stderr__"),
    *("os._exit", "os.abort", "os.kill", "os.write"),
}
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


def prints_or_exits(source: str) -> set[str]:
    """What a source names that prints, ends the process, or reads what is typed, whatever it calls it."""
    nodes = list(ast.walk(ast.parse(source)))
    imports = [(node, alias) for node in nodes if isinstance(node, ast.Import | ast.ImportFrom) for alias in node.names]
    meant = {alias.asname or alias.name: ".".join(filter(None, [getattr(node, "module", ""), alias.name]))
             for node, alias in imports}  # fmt: skip
    named = [ast.unparse(node).partition(".") for node in nodes if isinstance(node, ast.Name | ast.Attribute)]
    return {meant.get(first, first) + dot + rest for first, dot, rest in named} & FORBIDDEN


@pytest.mark.parametrize(
    "path", [f for f in FILES if ROOT / "cli" not in f.parents], ids=lambda p: str(p.relative_to(ROOT))
)
def test_nothing_below_the_command_line_prints_or_exits(path):
    assert not prints_or_exits(path.read_text())


@pytest.mark.parametrize(
    "source",
    ["print(1)", "exit()", "raise SystemExit", "raise SystemExit(2)", "import sys\nsys.exit(1)", "os._exit(1)",
     "sys.stdout.write('a')", "sys.stderr.flush()", "write = sys.stdout.write", "input()",
     "from sys import stdout\nstdout.write('a')",
     "from os import _exit as leave\nleave(1)", "import sys as s\ns.exit()", "show = print", "os.write(1, b'a')"],
)  # fmt: skip
def test_the_check_sees_every_way_to_print_or_exit(source):
    assert prints_or_exits(source)


def test_the_check_lets_other_names_pass():
    assert not prints_or_exits("done.stderr.decode(); self.exit(); sys.modules; blueprint(x); os.write_bytes")


@pytest.mark.parametrize("layer", LAYERS)
def test_every_module_is_named_in_the_design_notes(layer):
    """In backquotes, in the list of its package; the modules of an inner package go by its name."""
    notes = (ROOT / "docs" / "design.md").read_text()
    of_layer = re.search(rf"^- \*\*{layer}\*\*(.*?)\n(?=\S)", notes, re.DOTALL | re.MULTILINE)[1]
    inner = {path.parent.name for path in (ROOT / layer).glob("*/__init__.py")}
    modules = {path.stem for path in (ROOT / layer).glob("*.py")} - {"__init__"} | inner
    assert set(re.findall(r"`(\w+)`", of_layer)) == modules
