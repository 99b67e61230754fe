"""What is read from the cache is what would have been made, to the last bit; where it would not be, it is not read."""

import json
import os
import pickle
import shutil
import subprocess
import sys
from collections import OrderedDict
from pathlib import Path

import h5py
import numpy as np
import pytest
import symengine as se
from command_line import TRAJOPT, process, trajopt

from trajopt.problems.errors import Mistake, SpecError
from trajopt.transcription import constraint_kinds
from trajopt.transcription.cache import identity
from trajopt.transcription.cache.entries import entries
from trajopt.transcription.checked_files import ready
from trajopt.transcription.checked_files.ready import ready_all
from trajopt.transcription.collocation import kept
from trajopt.transcription.constraint_kinds import KINDS, ConstraintKind
from trajopt.transcription.program import machine_code
from trajopt.transcription.program.backend import told_apart

pytestmark = pytest.mark.usefixtures("folder")

OF_A_RUN = {"seconds", "created", "command", "wall"}  # not of what it solved
PLACES = {"DIMENSION_LIST", "REFERENCE_LIST"}  # where HDF5 has put the arrays


@pytest.fixture
def cache(tmp_path, monkeypatch):
    monkeypatch.setenv("TRAJOPT_CACHE", str(tmp_path / "cache"))
    return tmp_path / "cache"


def content(path: Path) -> dict:
    """Every array and attribute of a result file to the last bit, but for when and how long."""
    found = {}

    def read(name: str, node) -> None:
        if isinstance(node, h5py.Dataset) and not OF_A_RUN & set(name.split("/")):
            found[name] = repr(np.asarray(node[()]).tolist())
        lasting = node.attrs.keys() - OF_A_RUN - PLACES
        found.update({f"{name} {key}": str(node.attrs[key]) for key in lasting if not key.startswith("seconds_")})

    with h5py.File(path) as file:
        read("", file)
        file.visititems(read)
    assert len(found) > 100
    return found


def solved(name: str, *typed: str, cache: str = "") -> dict:
    """Solved in this process, in which nothing is in memory."""
    with pytest.MonkeyPatch.context() as patch:
        for memory in ((machine_code, "_code"), (machine_code, "_values"), (kept, "_kept")):
            patch.setattr(*memory, OrderedDict())
        if cache:
            patch.setenv("TRAJOPT_CACHE", cache)
        return solved_again(name, *typed)


def solved_again(name: str, *typed: str) -> dict:
    """Solved in this process, whatever it has solved before."""
    run = trajopt("solve", *typed, "-q", "--force", "-o", f"{name}.h5")
    assert (run.exit_code, run.stderr) == (0, "")
    return content(Path(f"{name}.h5"))


def solved_by_another_process(name: str, *typed: str) -> dict:
    """There texts have other hashes."""
    run = process("solve", *typed, "-q", "--force", "-o", f"{name}.h5")
    assert (run.returncode, run.stderr) == (0, "")
    return content(Path(f"{name}.h5"))


MOVE = """
trajopt: 1
name: a move
parameters: {c: 1.0}
tables: {drag: {file: drag.csv}}
time: {initial: 0, final: 1}
states: {x: {rate: u - c*drag(x), initial: 0, final: 1}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
"""
DRAG = "x,drag\n0,1\n1,2\n2,3\n"

CASES = {
    "another number": ("cartpole", "--set", "parameters.u_max=14"),
    "refined": ("cartpole", "--refine", "1e-7"),
    "shooting": ("block_move_min_force", "--method", "runge-kutta-4", "--segments", "20"),
    "other starts": ("brachistochrone", "--segments", "10", "--starts", "3"),
    "tables": ("move.yaml",),
    "several phases": ("block_move_three_phases",),
    "path constraints that hold at the ends": ("goddard_three_phases",),
    "a path constraint of states": ("goddard_speed_limit", "--set", "refine.tolerance=1e-3"),
}


@pytest.mark.parametrize("typed", CASES.values(), ids=CASES)
def test_the_result_is_the_same_to_the_last_bit(typed, cache, folder):
    """In one process, whatever it solved before, and in two; and whether programs are made or read."""
    (folder / "move.yaml").write_text(MOVE)
    (folder / "drag.csv").write_text(DRAG)
    without = solved("without", *typed, cache="off")
    assert not cache.exists()
    first = solved("first", *typed)
    written = {path.name: path.stat().st_mtime_ns for path in cache.iterdir()}
    second = solved_by_another_process("second", *typed)
    assert written and written == {path.name: path.stat().st_mtime_ns for path in cache.iterdir()}  # made once
    again = solved_again("again", *typed)
    for key, value in without.items():
        assert first[key] == second[key] == again[key] == value, key


def test_other_numbers_use_what_is_kept(cache):
    """One compilation serves every number, and gives what they would have given alone."""
    solved("first", "cartpole")
    large = sorted(own.name for own in entries() if own.size > 20_000)
    after = solved("after", "cartpole", "--set", "parameters.u_max=14")
    assert sorted(own.name for own in entries() if own.size > 20_000) == large
    assert after == solved("alone", "cartpole", "--set", "parameters.u_max=14", cache="off")


@pytest.mark.parametrize("at", [30, -1])
def test_damaged_entries_change_nothing(at, cache):
    whole = solved("whole", "cartpole")
    for path in cache.iterdir():
        content = bytearray(path.read_bytes())
        content[at] ^= 255
        path.write_bytes(content)
    assert solved("again", "cartpole") == whole == solved("third", "cartpole")


def test_without_a_home_there_is_no_cache_and_no_word(folder):
    environment = {key: value for key, value in os.environ.items() if key not in ("TRAJOPT_CACHE", "XDG_CACHE_HOME")}
    run = process("solve", "cartpole", "-q", env={**environment, "HOME": "/proc/none"})
    assert (run.returncode, run.stdout, run.stderr) == (0, "", "")


READERS = {"pyomo", "pydantic", "yaml", "importlib.metadata"}
NOT_NEEDED = READERS | {"trajopt.problems.schema.spec", "trajopt.problems.load"}


def test_what_is_known_needs_neither_schema_nor_pyomo(cache):
    """Not after the first solve of a file; with other numbers the file is read, and its program is known."""

    def loaded(*typed: str) -> set[str]:
        command = [sys.executable, "-X", "importtime", *TRAJOPT[1:], "solve", "cartpole", "-q", "--force", *typed]
        run = subprocess.run(command, capture_output=True, text=True, check=True)
        return {line.rpartition("|")[2].strip() for line in run.stderr.splitlines()}

    assert loaded() >= NOT_NEEDED
    assert not loaded() & NOT_NEEDED
    assert "pyomo" not in loaded("--set", "parameters.u_max=14")
    large = "--segments", "1000", "--set", "solver.coarse_start=false"
    assert "pyomo" in loaded(*large) and "pyomo" not in loaded(*large)


def read(*given: str, file: str = "move.yaml"):
    (own,) = ready_all([file], given)
    return own


def test_a_changed_file_is_read_again(cache, folder):
    path = folder / "move.yaml"
    path.write_text(MOVE.replace("tables: {drag: {file: drag.csv}}", "").replace("drag(x)", "x"))
    first = read()
    assert first.loaded and not read().loaded and read().full == first.full and read().spec().name == "a move"
    assert read("parameters.c=2").loaded and json.loads(read("parameters.c=2").full)["parameters"]["c"] != 1.0
    path.write_text(path.read_text().replace("c: 1.0", "c: 3.0"))
    again = read()
    assert again.loaded and again.problems[0].numbers["c"] == 3.0 == read().problems[0].numbers["c"]


def test_a_file_with_others_beside_it_is_read_each_time(cache, folder):
    (folder / "move.yaml").write_text(MOVE)
    (folder / "drag.csv").write_text(DRAG)
    assert read().loaded and (known := read()).loaded
    (folder / "drag.csv").write_text("x,drag\n0,1\n1,2\n2,4\n")
    assert read().full != known.full


def test_a_mistake_is_told_again(cache, folder):
    (folder / "move.yaml").write_text(
        MOVE.replace("rate: u", "rate: v").replace("tables: {drag: {file: drag.csv}}", "")
    )
    for _ in range(2):
        with pytest.raises(SpecError, match=r"move\.yaml:"):
            read()


def test_what_is_on_the_way_is_not_kept(cache):
    assert read(file="bouncing_pendulum").loaded
    own = read(file="bouncing_pendulum")
    assert bool(own.loaded) != own.direct


def test_the_engine_is_asked_about_its_options_again(cache, monkeypatch):
    read("solver.mu_strategy=adaptive", file="cartpole")
    assert not read("solver.mu_strategy=adaptive", file="cartpole").loaded
    monkeypatch.setattr(ready, "check_engine_options", lambda *_: [Mistake("solver", "not here", "take another")])
    assert read("solver.mu_strategy=adaptive", file="cartpole").loaded


def test_equal_texts_are_of_equal_expressions():
    x, third = se.Symbol("v0"), 0.1 + 0.2
    pairs = [
        (0.3 * x, third * x),
        (x**0.3, x**third),
        (se.sin(x) + 0.3, se.sin(x) + third),
        (se.Piecewise((x, x > 0.3), (0, True)), se.Piecewise((x, x > third), (0, True))),
        (se.Max(x, 0.3), se.Max(x, third)),
        (2 * x, 2.0 * x),
        (x / 3, x * (1 / 3)),
        (0.0 * x + x, x),
    ]
    for one, other in pairs:
        assert (told_apart([one]) == told_apart([other])) == (one == other), (one, other)
    assert told_apart([0.3 * x]) == told_apart([se.Symbol("v0") * 0.3])


def test_a_changed_program_is_another(tmp_path):
    """A copy of trajopt has an identity of its own, and one more when one of its files is touched."""
    root = Path(identity.__file__).parents[2]
    shutil.copytree(root / "transcription", tmp_path / "transcription")
    shutil.copytree(root / "problems", tmp_path / "problems")
    before = list(identity._files(str(tmp_path), ".py"))
    assert before == list(identity._files(str(tmp_path), ".py")) and len(before) > 200
    os.utime(tmp_path / "problems" / "lean" / "records.py", (1, 1))
    assert before != list(identity._files(str(tmp_path), ".py"))


@pytest.mark.parametrize(
    ("changed", "value"),
    [("_processor", b"another"), ("_library", ["another"])],
)
def test_another_machine_or_library_is_another(changed, value, monkeypatch):
    own = identity.identity.__wrapped__()
    monkeypatch.setattr(identity, changed, lambda *_: value)
    assert own and own != identity.identity.__wrapped__()


def test_another_python_is_another(monkeypatch):
    own = identity.identity.__wrapped__()
    monkeypatch.setattr(sys, "version", "9.9")
    assert own != identity.identity.__wrapped__()


def test_where_the_processor_is_not_told_nothing_is_kept(tmp_path, monkeypatch):
    monkeypatch.setattr(identity, "PROCESSOR", tmp_path / "cpuinfo")
    assert identity.identity.__wrapped__() is None
    (tmp_path / "cpuinfo").write_text("processor : 0\nmodel name : some\n")
    assert identity.identity.__wrapped__() is None


def test_the_command(cache):
    def told(*arguments):
        run = trajopt("cache", *arguments, "--json")
        assert run.exit_code == 0
        return json.loads(run.stdout)

    nothing = {"folder": str(cache), "entries": 0, "bytes": 0, "deleted": 0}
    assert told() == nothing
    solved("a", "cartpole")
    full = told()
    assert full["entries"] == len(list(cache.iterdir())) and full["bytes"] > 10_000
    assert str(cache) in trajopt("cache").stdout
    assert told("clear") == {**nothing, "deleted": full["entries"]} and not list(cache.iterdir())
    assert "deleted" in trajopt("cache", "clear").stdout


def test_the_command_tells_why_there_is_no_cache(cache, monkeypatch):
    cache.mkdir(mode=0o755)
    run = trajopt("cache")
    assert run.exit_code == 3 and "chmod 700" in run.stderr and str(cache) in run.stderr
    monkeypatch.setenv("TRAJOPT_CACHE", "off")
    run = trajopt("cache", "clear")
    assert run.exit_code == 2 and "unset TRAJOPT_CACHE" in run.stderr
    assert trajopt("cache", "wipe").exit_code == 2


def test_a_kind_of_constraint_is_a_row_of_its_table():
    """Also one that was read from the disk: kinds are compared by identity."""
    assert all(pickle.loads(pickle.dumps(kind)) is kind for kind in KINDS)
    rows = [own for own in vars(constraint_kinds).values() if isinstance(own, ConstraintKind)]
    assert sorted(map(str, rows)) == sorted(map(str, KINDS))
