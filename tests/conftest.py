"""What tests of several files share: a folder of their own to work in, and processes that start as a user's do."""

import atexit
import gc
import os
import shutil
import signal
import sys
import tempfile

import pytest

# As trajopt does, but before a test file imports numpy: more threads than cores only wait for each other.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

# As workers of a sweep do: IPOPT takes and frees the same memory in each solve, and to have it from the system anew
# takes a twentieth of the time of all tests. The C library of the workers that pytest starts reads these.
for threshold in ("MALLOC_TRIM_THRESHOLD_", "MALLOC_MMAP_THRESHOLD_"):
    os.environ.setdefault(threshold, str(64 << 20))

# Where this is set, each process that a test starts compiles all modules anew: a fifth of the time of such tests.
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False  # nor the tests themselves, which pytest rewrites

# All tests keep what they compile in one cache of their own, so that most of them solve by what others have kept.
if "TRAJOPT_CACHE" not in os.environ:
    os.environ["TRAJOPT_CACHE"] = tempfile.mkdtemp(prefix="trajopt-tests-")
    atexit.register(shutil.rmtree, os.environ["TRAJOPT_CACHE"], ignore_errors=True)

# A shell that starts the tests in the background has SIGINT ignored, and nohup SIGHUP: all processes below would do so.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)
if signal.getsignal(signal.SIGHUP) is signal.SIG_IGN:
    signal.signal(signal.SIGHUP, signal.SIG_DFL)


def pytest_collectstart():
    """Pyomo as trajopt loads it: where a test file is the first to do so, it brings all of SciPy's statistics."""
    import trajopt.transcription.libraries.pyomo  # noqa: F401


def pytest_collection_finish():
    """Seven thousand tests are no garbage, and need not be searched for it each time that there might be some."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 100)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which is the current one as long as the test runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
