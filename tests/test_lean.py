"""What commands do not import: each of these takes longer to load than many a solve."""

import subprocess
import sys

import pytest

HEAVY = {"scipy.interpolate", "scipy.stats", "scipy.optimize", "matplotlib", "dask", "jinja2", "latex2mathml"}
START = "from trajopt.cli.main import main; main()"


@pytest.mark.parametrize(
    ("command", "lacks"),
    [
        ("--help", HEAVY | {"pydantic", "pyomo.core", "h5py", "pint", "multiprocessing"}),
        ("solve --help", HEAVY | {"pyomo.core", "h5py", "pint"}),
        ("check cartpole", HEAVY),
        ("check van_der_pol", HEAVY | {"pint"}),  # a file without units
        ("solve block_move_min_force -q -o a.h5", HEAVY | {"pint", "multiprocessing", "numpy.ma", "numpy.random"}),
    ],
)
def test_a_command_imports_what_it_needs(command, lacks, folder):
    told = [sys.executable, "-X", "importtime", "-c", START, *command.split()]
    run = subprocess.run(told, capture_output=True, text=True, check=True)
    loaded = {line.rpartition("|")[2].strip() for line in run.stderr.splitlines()}
    assert "typer" in loaded and not loaded & lacks


AFTER_PYOMO = [("scipy.sparse.linalg", "scipy.stats"), ("matplotlib", "matplotlib.pyplot")]


@pytest.mark.parametrize(("imported", "lacks"), AFTER_PYOMO)
def test_a_library_that_is_needed_after_pyomo_brings_no_more(imported, lacks):
    loaded = f"print('pyomo' in sys.modules, {lacks!r} in sys.modules)"
    script = f"import sys, trajopt.transcription.solve, {imported}; {loaded}"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout == "True False\n"
