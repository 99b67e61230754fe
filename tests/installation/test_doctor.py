"""`trajopt doctor`: what it tells of an installation that is whole, and of one with broken libraries."""

import json
import os
from importlib.metadata import requires, version

import pytest
from command_line import process, trajopt
from named import share

from trajopt.results.installation import PARTS, installation


@pytest.fixture(scope="module")
def told():
    return trajopt("doctor", "--json")


def test_it_solves_and_tells_what_it_is_made_of(told):
    assert told.exit_code == 0
    found = json.loads(told.stdout)
    assert found["solves"] and found["trial"]["objective"] == pytest.approx(12, rel=1e-9)
    assert found["trajopt"] == version("trajopt") and found["packages"]["pyomo"] == version("pyomo")
    assert len(found["packages"]) == sum("extra" not in text for text in requires("trajopt"))
    assert found["linear_solvers"]["mumps"] and found["ipopt"].startswith("3.") and found["hdf5"][0] in "12"
    assert found["derivatives"] in ("llvm", "lambda") and not found["unusable"] and not found["misfits"]
    assert set(found["parts"]) == set(PARTS)


def test_the_table_has_a_line_for_each_of_these():
    run = trajopt("doctor")
    names = [line.split()[0] for line in run.stdout.splitlines()]
    assert run.exit_code == 0 and run.stdout.startswith("trajopt 0.1.0: it solves\n")
    assert {"trial", "python", "system", "packages", "ipopt", "solvers", "hdf5", "cache", *PARTS} <= set(names)
    assert "objective 12 is right" in run.stdout and "numpy " + version("numpy") in run.stdout


def test_what_is_missing_is_told_with_its_remedy(monkeypatch, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))  # no ffmpeg there
    films = installation(load=False)["parts"]["films"]
    assert films["missing"] == ["ffmpeg"] and "ffmpeg" in films["remedy"]
    (tmp_path / "ffmpeg").touch(0o755)
    assert installation(load=False)["parts"]["films"]["missing"] == []


BROKEN = {
    "cyipopt": ("raise ImportError('libipopt.so.3: cannot open shared object file')", "libipopt.so.3", ["ipopt"]),
    "h5py": ("raise RuntimeError('built for another HDF5')", "built for another HDF5", ["hdf5"]),
    "symengine": ("import os, signal; os.kill(os.getpid(), signal.SIGILL)", "ended by SIGILL", []),
}
"""Package -> what it does when it is imported, what is told, and what then cannot be told."""


@pytest.mark.parametrize("package", BROKEN)
def test_a_broken_library_is_told_with_a_remedy(package, tmp_path):
    source, reason, lacking = BROKEN[package]
    (tmp_path / f"{package}.py").write_text(source)
    run = process("doctor", "--json", env={**os.environ, "PYTHONPATH": str(tmp_path)})
    found = json.loads(run.stdout)
    assert run.returncode == 1 and not run.stderr
    assert not found["solves"] and reason in found["trial"]["trouble"] and "pip install" in found["trial"]["remedy"]
    assert found["trial"]["crashed"] is ("SIG" in reason)
    assert all(reason in found["unusable"][key] and found[key] is None for key in lacking)


def test_a_version_that_does_not_fit_is_told(tmp_path):
    own = tmp_path / "pyomo-5.7.dist-info"
    own.mkdir()
    (own / "METADATA").write_text("Metadata-Version: 2.1\nName: pyomo\nVersion: 5.7\n")
    run = process("doctor", env={**os.environ, "PYTHONPATH": str(tmp_path)})
    (line,) = (line for line in run.stdout.splitlines() if line.startswith("misfit"))
    assert run.returncode == 0 and "pyomo has version 5.7: pip install 'pyomo<6.11,>=6.10.1'" in line


def test_no_place_for_temporary_files(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "none"))
    run = trajopt("doctor")
    assert run.exit_code == 1 and "CANNOT SOLVE" in run.stdout and "set TMPDIR" in run.stdout


@pytest.mark.parametrize(
    ("solver", "library"),
    share([("ma97", ""), ("ma97", "libm.so.6"), ("MA97", "none/libhsl.so"), ("ma57", "/etc/hostname")], 2, 1),
)
def test_a_linear_solver_without_its_library_is_refused(solver, library):
    """For ma97, IPOPT itself crashes."""
    named = ["--set", f"solver.hsllib={library}"] if library else []
    run = process("check", "cartpole", "--set", f"solver.linear_solver={solver}", *named)
    assert run.returncode == 2 and run.stderr.startswith("error: --set solver.linear_solver: IPOPT cannot load")


def test_a_scaling_without_its_library_is_refused():
    run = trajopt("check", "cartpole", "--set", "solver.linear_system_scaling=mc19")
    assert run.exit_code == 2 and "IPOPT cannot load the scaling mc19" in run.stderr
    assert trajopt("check", "cartpole", "--set", "solver.linear_system_scaling=slack-based").exit_code == 0
