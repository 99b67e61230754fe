"""The rooms: imports point one way, cli -> results -> transcription -> problems, and nowhere in a circle."""

import ast
import re
import tomllib
from collections import defaultdict
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest
from repository import ROOT

from trajopt.transcription import constraint_kinds
from trajopt.transcription.constraint_kinds import ConstraintKind
from trajopt.transcription.schemes.segment import Segment
from trajopt.transcription.schemes.table import METHODS
from trajopt.transcription.transcribe import METHOD_KINDS

LAYERS = ("problems", "transcription", "results", "cli")
MAX_FILES = 12
FORBIDDEN = {
    *("print", "input", "exit", "quit", "SystemExit"),
    *("sys.exit", "sys.stdout", "sys.stderr", "sys.__stdout__", "sys.__stderr__"),
    *("os._exit", "os.abort", "os.kill", "os.write"),
}
FILES = [path for layer in LAYERS for path in sorted((ROOT / layer).rglob("*.py"))]
ROOMS = sorted({path.parent for path in FILES})


def module_of(path: Path) -> str:
    """The name of a file's module: "problems.yaml.document", a package by its own name."""
    parts = path.relative_to(ROOT).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {module_of(path) for path in FILES}


def imported_modules(path: Path) -> set[str]:
    """The modules of trajopt that a file imports: at its top, inside functions, or for the type checker only."""
    package = path.relative_to(ROOT).parent.parts
    found = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            base = ["trajopt", *package][: len(package) + 2 - node.level] if node.level else []
            module = ".".join([*base, *filter(None, [node.module])])
            inner = [f"{module}.{alias.name}" for alias in node.names]
            names = [name if name.removeprefix("trajopt.") in MODULES else module for name in inner]
        else:
            continue
        found |= {name.removeprefix("trajopt.") for name in names if name.startswith("trajopt.")}
    return found


def room_of(module: str) -> str:
    """The room of a module, or the module itself if it is a door: a file at the top of one of the four packages."""
    parts = module.split(".")
    is_door = len(parts) == 2 and not (ROOT / Path(*parts)).is_dir()
    return module if is_door else ".".join(parts[:2])


def circle(graph: dict[str, set[str]]) -> list[str]:
    """One circle of a graph, or nothing."""
    try:
        list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        return error.args[1]
    return []


@cache
def imports() -> dict[str, set[str]]:
    """What each module imports, read when the first test asks: every worker loads this file."""
    return {module_of(path): imported_modules(path) for path in FILES}


def layer(module: str) -> int:
    return LAYERS.index(module.split(".", maxsplit=1)[0])


def test_no_import_points_up():
    above = {own: {other for other in imported if layer(other) > layer(own)} for own, imported in imports().items()}
    assert len(above) > 400 and not {own: found for own, found in above.items() if found}


def test_no_circle_between_files():
    assert not circle(imports())


def test_no_circle_between_rooms():
    """A door is a room of its own: it opens onto the rooms behind it, and they may stand on other doors."""
    graph = defaultdict(set)
    for module, imported in imports().items():
        graph[room_of(module)] |= {room_of(other) for other in imported} - {room_of(module)}
    assert not circle(graph)


def test_the_check_sees_every_way_to_import(tmp_path):
    assert imported_modules(ROOT / "cli" / "main.py") >= {"cli.app"}  # inside a function
    assert imported_modules(ROOT / "transcription" / "collocation" / "segments.py") >= {
        "problems.problem",  # from ...problems.problem import
        "transcription.collocation.builder",  # from .builder import
    }
    assert imported_modules(ROOT / "results" / "reproduction" / "reproduce.py") >= {
        "results.reproduction.figures.biped",  # from .figures import biped
        "results.reproduction.page",  # from . import page
    }
    assert circle({"a": {"b"}, "b": {"c"}, "c": {"a"}}) and not circle({"a": {"b", "c"}, "b": {"c"}})


def test_a_room_is_small_and_says_what_it_holds():
    """At most twelve files, and one line that tells what they are for."""
    for room in ROOMS:
        assert len([path for path in room.glob("*.py") if path.name != "__init__.py"]) <= MAX_FILES, room
        assert ast.get_docstring(ast.parse((room / "__init__.py").read_text())), room


def test_every_room_is_installed():
    """Each under the name of its folder; the package `trajopt` itself is a room of results/."""
    setup = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]
    assert setup["package-dir"]["trajopt"] == "results/package"
    rooms = [room for room in sorted(ROOMS) if room != ROOT / "results" / "package"]
    assert setup["packages"] == ["trajopt", *("trajopt." + ".".join(room.relative_to(ROOT).parts) for room in rooms)]


def test_types_are_shipped():
    """Type checkers use the annotations of an installed package only where it says so, for all packages in it."""
    data = tomllib.loads((ROOT / "pyproject.toml").read_text())["tool"]["setuptools"]["package-data"]
    assert data["trajopt"] == ["py.typed"] and (ROOT / "results" / "package" / "py.typed").exists()


def prints_or_exits(source: str) -> set[str]:
    """What a source names that prints, ends the process, or reads what is typed, whatever it calls it."""
    nodes = list(ast.walk(ast.parse(source)))
    imports = [(node, alias) for node in nodes if isinstance(node, ast.Import | ast.ImportFrom) for alias in node.names]
    meant = {alias.asname or alias.name: ".".join(filter(None, [getattr(node, "module", ""), alias.name]))
             for node, alias in imports}  # fmt: skip
    named = [ast.unparse(node).partition(".") for node in nodes if isinstance(node, ast.Name | ast.Attribute)]
    return {meant.get(first, first) + dot + rest for first, dot, rest in named} & FORBIDDEN


BELOW = [path for path in FILES if ROOT / "cli" not in path.parents]


def test_nothing_below_the_command_line_prints_or_exits():
    assert not {path: found for path in BELOW if (found := prints_or_exits(path.read_text()))}


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
    """Each room has a line in the drawing of its package, which names its modules."""
    notes = (ROOT / "docs" / "design.md").read_text()
    drawn = re.search(rf"^    {layer}/\n((?:        .*\n)+)", notes, re.MULTILINE)[1]
    lines = [line.split(":") for line in drawn.splitlines()]
    rooms = {room.strip(): set(modules.split()) for room, modules in lines}
    found = defaultdict(set)
    for path in (ROOT / layer).rglob("*.py"):
        if path.name != "__init__.py":
            found["/".join(path.relative_to(ROOT / layer).parent.parts) or "doors"].add(path.stem)
    assert rooms == found


def test_only_the_rooms_of_result_files_and_of_sweeps_know_hdf5():
    importing = {path for path in FILES if re.search(r"^ *(import|from) h5py", path.read_text(), re.M)}
    assert {path.parent.relative_to(ROOT).as_posix() for path in importing} == {
        "results/declared",
        "results/file",
        "results/sweep",
    }


def test_what_depends_on_a_method_or_a_constraint_is_asked_of_it():
    """Kinds of methods are told apart in their table only, and kinds of constraints in theirs."""
    kinds = "|".join(row.name for row in vars(constraint_kinds).values() if isinstance(row, ConstraintKind))
    for path in FILES:
        text = path.read_text()
        assert not re.search(r"isinstance\([^()]*(\([^()]*\))?[^()]*, *(Scheme|FiniteDifference|Shooting)\b", text), (
            path
        )
        assert not re.search(rf"\.kind (==|!=|in|not in) \(?[\"']({kinds})[\"']", text), path


@pytest.mark.parametrize("name", METHODS)
def test_every_method_says_what_a_segment_says(name):
    scheme = METHODS[name].of_degree()
    asked = [key for key in vars(Segment) if not key.startswith("_")]
    assert len(asked) > 20
    assert [key for key in asked if not hasattr(scheme, key)] == []
    assert scheme.kind in METHOD_KINDS


def unnamed_arguments(source: str) -> dict[str, list[str]]:
    """Public functions with more than two arguments -> those that no line of the docstring begins with."""
    found = {}
    for node in ast.parse(source).body:
        if not isinstance(node, ast.FunctionDef) or node.name.startswith("_"):
            continue
        args = [arg.arg for arg in (*node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs)]
        text = ast.get_docstring(node) or ""
        missing = [a for a in args if not re.search(rf"^\s*(\w+, )*\*{{0,2}}{a}(, \w+)*:", text, re.MULTILINE)]
        if len(args) > 2 and missing:
            found[node.name] = missing
    return found


def test_public_functions_name_their_arguments_one_a_line():
    assert not {path: found for path in BELOW if (found := unnamed_arguments(path.read_text()))}


def test_the_check_sees_an_argument_that_has_no_line():
    told = 'def f(a, b, c):\n    """One.\n\n    a, b: two.\n    {}c: three.\n    """'
    assert not unnamed_arguments(told.format(""))
    assert unnamed_arguments(told.format("and of ")) == {"f": ["c"]}
    assert unnamed_arguments("def f(a, *, b, c): pass") == {"f": ["a", "b", "c"]}
    assert not unnamed_arguments("def f(a, b): pass") and not unnamed_arguments("def _f(a, b, c): pass")
