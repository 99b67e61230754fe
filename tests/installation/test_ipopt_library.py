"""`solver.library`: the IPOPT of the wheel, or that of CasADi's, by a word; one in a process."""

import json
import os
from importlib.util import find_spec

import h5py
import pytest
from command_line import process

from trajopt.problems.errors import SpecError
from trajopt.transcription.engines.ipopt import check_options
from trajopt.transcription.engines.ipopt_library import CASADI, load_library, loaded
from trajopt.transcription.loading import load_file

ALREADY = "this process has loaded the bundled IPOPT already"
needs_casadi = pytest.mark.skipif(find_spec("casadi") is None, reason="needs CasADi: pip install casadi==3.8.2")


@pytest.fixture
def bundled():
    load_library()
    assert loaded().library == "bundled" and loaded().version.startswith("3.")


@pytest.mark.usefixtures("bundled")
def test_a_process_has_one_library():
    with pytest.raises(SpecError, match=ALREADY):
        load_library(CASADI)
    (mistake,) = check_options({"library": CASADI, "max_iter": 3})
    assert mistake.where == "solver.library" and "process of its own" in mistake.remedy
    assert check_options({"library": "bundled", "max_iter": 3}) == []
    assert load_file("block_move_min_force", ["solver.library=bundled"]).solver.options == {"library": "bundled"}


@pytest.mark.parametrize("named", ["./libipopt.so", "/usr/lib/libipopt.so.3", "CasADi", "[casadi]", "3"])
def test_a_file_names_no_library_but_those_of_the_list(named):
    with pytest.raises(SpecError, match=r"solver\.library") as refused:
        load_file("block_move_min_force", [f"solver.library={named}"])
    assert len(refused.value.mistakes) == 1 and "'bundled' or 'casadi'" in str(refused.value)


def test_another_engine_has_no_library():
    with pytest.raises(SpecError, match="the Newton engine has no such option"):
        load_file("pendulum", ["solver.library=bundled"])


@pytest.mark.parametrize(("file", "told"), [("libother.so", "that is installed brings no IPOPT"),
                                            ("libipopt.so.3", "does not fit")])  # fmt: skip
def test_a_casadi_without_ipopt_is_told_in_one_sentence(file, told, tmp_path):
    """A package of that name that was built without it, or for another machine, comes before any other."""
    (tmp_path / "casadi").mkdir()
    (tmp_path / "casadi" / file).write_text("no library")
    (tmp_path / "casadi" / "__init__.py").write_text("raise SystemExit('it is not imported')\n")
    environment = {**os.environ, "PYTHONPATH": str(tmp_path)}
    run = process("solve", "block_move_min_force", "--set", "solver.library=casadi", cwd=tmp_path, env=environment)
    assert run.returncode == 2 and run.stdout == ""
    assert run.stderr.startswith("error: --set solver.library: the ") and run.stderr.count("\n") == 1
    assert "package casadi " + told + "; pip install casadi==" in run.stderr


@pytest.mark.skipif(find_spec("casadi") is not None, reason="CasADi is installed")
def test_a_folder_named_casadi_is_no_package(tmp_path):
    (tmp_path / "casadi").mkdir()
    (tmp_path / "casadi" / "libipopt.so.3").write_text("not loaded")
    run = process("check", "block_move_min_force", "--set", "solver.library=casadi", cwd=tmp_path)
    assert run.returncode == 2 and "the package casadi is not installed; pip install" in run.stderr


@needs_casadi
@pytest.mark.parametrize("name", ["cartpole", "block_move_min_force"])
def test_the_results_of_both_agree_and_tell_which_it_was(name, tmp_path):
    told = {}
    for library in ("bundled", "casadi"):
        chosen = ["--set", f"solver.library={library}", "--set", "solver.print_level=5"]
        run = process("solve", name, "--json", *chosen, "-o", f"{library}.h5", cwd=tmp_path)
        told[library] = json.loads(run.stdout)["objective"]
        with h5py.File(tmp_path / f"{library}.h5") as file:
            solver = dict(file["solver"].attrs)
            assert solver["library"] == library and file.attrs["ipopt_version"] == solver["ipopt"]
            # in IPOPT's own words: the library that has run, not the one that was asked for
            assert f"This is Ipopt version {solver['ipopt']}," in run.stderr
    assert told["casadi"] == pytest.approx(told["bundled"], rel=1e-8)


@needs_casadi
def test_the_workers_of_a_sweep_have_it(tmp_path):
    swept = ["sweep", "block_move_min_force", "--over", "mesh.0.segments=5,6,7", "--set", "solver.library=casadi"]
    run = process(*swept, "--keep", "full", "-j", "2", "-o", "s", cwd=tmp_path)
    assert run.returncode == 0, run.stderr
    for path in (tmp_path / "s" / "results").glob("*.h5"):
        with h5py.File(path) as file:
            assert file["solver"].attrs["library"] == "casadi"
