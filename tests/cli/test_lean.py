"""What commands do not import: each of these takes longer to load than many a solve."""

import subprocess
import sys
from pathlib import Path

import pytest

HEAVY = {"scipy.interpolate", "scipy.stats", "scipy.optimize", "matplotlib", "dask", "jinja2", "latex2mathml"}
OTHERS = {"trajopt.cli.solving.sweep", "trajopt.cli.result_files.plot", "trajopt.cli.problem_files.export"}  # commands
FAILURE = {f"trajopt.transcription.failure.{part}" for part in ("relax", "elastic", "conflict", "non_finite", "kinks")}
START = "from trajopt.cli.main import main; main()"


@pytest.mark.parametrize(
    ("command", "lacks"),
    [
        ("--help", HEAVY | {"pydantic", "pyomo.core", "h5py", "pint", "multiprocessing"}),
        ("solve --help", HEAVY | {"pyomo.core", "h5py", "pint"}),
        ("check cartpole", HEAVY),
        ("check van_der_pol", HEAVY | {"pint"}),  # a file without units
        (
            "solve block_move_min_force -q -o a.h5",
            HEAVY | OTHERS | FAILURE | {"pint", "multiprocessing", "numpy.ma", "numpy.random"},
        ),
    ],
)
def test_a_command_imports_what_it_needs(command, lacks, folder):
    told = [sys.executable, "-X", "importtime", "-c", START, *command.split()]
    run = subprocess.run(told, capture_output=True, text=True, check=True)
    loaded = {line.rpartition("|")[2].strip() for line in run.stderr.splitlines()}
    assert "typer" in loaded and not loaded & lacks


PARTS = [("scipy.sparse.linalg", "scipy.stats"), ("matplotlib", "matplotlib.pyplot")]


@pytest.mark.parametrize(("imported", "lacks"), PARTS)
@pytest.mark.parametrize("first", [True, False])
def test_a_part_of_a_library_brings_no_more_of_it_because_of_pyomo(imported, lacks, first):
    """Loaded before Pyomo, as tables and simulated guesses do, or after it; and it is there once."""
    imports = [imported, "trajopt.transcription.collocation.model"][:: 1 if first else -1]
    library = imported.partition(".")[0]
    script = f"""
import sys, {imports[0]}
own = sys.modules.get({library!r})
import {imports[1]}, {library}
print("pyomo" in sys.modules, {lacks!r} in sys.modules, own in (None, {library}))
"""
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "True False True\n"


TABLE = """
trajopt: 1
name: slide
tables:
  drag: {points: {v: [-9, -1, 0, 1, 2, 9]}, values: [81, 1, 0, 1, 4, 81]}
states:
  x: {rate: v, initial: 0, final: 1}
  v: {rate: u - drag(v), initial: 0, final: 0}
controls: {u: {}}
time: {initial: 0, final: 1}
objective: {minimize: {integral: u**2}}
mesh: [{method: trapezoid, segments: 5}]
"""


@pytest.mark.parametrize("more", ["", "guess: simulate\n"])
def test_a_file_that_needs_scipy_brings_no_more_of_it(more, folder):
    Path("slide.yaml").write_text(TABLE + more)
    told = [sys.executable, "-X", "importtime", "-c", START, "solve", "slide.yaml", "-q"]
    run = subprocess.run(told, capture_output=True, text=True, check=False)
    loaded = {line.rpartition("|")[2].strip() for line in run.stderr.splitlines()}
    assert run.returncode in (0, 4) and "scipy.interpolate" in loaded and "scipy.stats" not in loaded
