"""The command line inside this process and as a process, for the tests that go through it."""

import json
import subprocess
import sys
from contextlib import contextmanager
from functools import cache
from pathlib import Path

import typer.testing
from typer.main import get_command
from typer.testing import CliRunner

from trajopt.cli.app import app
from trajopt.cli.errors import TOLERANCE_MISSED

typer.testing._get_command = cache(get_command)  # made anew for each run it takes longer than many a run

TRAJOPT = [sys.executable, "-c", "from trajopt.cli.main import main; main()"]  # the console script, in any environment


OPTION_FILES = {  # what an `ipopt.opt` in the current folder might say
    "two iterations": "max_iter 2\n",
    "an output file": "output_file told.txt\nfile_print_level 5\nprint_level 5\n",
    "an invalid line": "no_such_option 3\n",
    "a library": "linear_solver ma57\nhsllib ./libhsl.so\n",
}


def trajopt(*arguments, given: str = ""):
    """A run inside this process: no start-up to pay. Anything but an exit with a code is a bug.

    given: what stands on standard input.
    """
    result = CliRunner().invoke(app, [str(argument) for argument in arguments], input=given)
    assert result.exception is None or isinstance(result.exception, SystemExit), repr(result.exception)
    return result


def process(*arguments, **options):
    """A run as a user's shell starts it."""
    return subprocess.run([*TRAJOPT, *map(str, arguments)], capture_output=True, text=True, check=False, **options)


@contextmanager
def started(*arguments: str):
    """A process that a test watches while it runs; it is killed when the test is done with it."""
    run = subprocess.Popen([*TRAJOPT, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    try:
        yield run
    finally:
        run.kill()
        run.communicate()


def solved_once(path: Path, *arguments, code: int = 0) -> Path:
    """The result file at `path`, made by `trajopt solve *arguments` when it is first asked for.

    code: that it ends with; a solved problem may have missed its tolerance, as on the coarse meshes of tests.
    """
    if not path.exists():
        run = trajopt("solve", *arguments, "-q", "-o", path)
        codes = (code, TOLERANCE_MISSED) if code == 0 else (code,)
        assert run.exit_code in codes and path.exists(), run.output
    return path


def strict_json(text: str):
    """The value of a JSON text; NaN and Infinity, which Python would take, are no JSON."""

    def refuse(name: str):
        raise ValueError(f"{name} is no JSON")

    return json.loads(text, parse_constant=refuse)
