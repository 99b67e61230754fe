"""trajopt: trajectory optimization from a problem file."""

from __future__ import annotations

import gc
import os
import sys

from . import signals

GARBAGE = (200_000, 20, 100)
"""Thresholds of the collector of garbage. Loading and one solve stay below the first, so that nothing is collected;
what goes on for longer is, at intervals that cost little."""


def main() -> None:
    """Run the command line.

    The process ends here, not by Python's own way out, which takes the handlers of signals away before it has ended.
    """
    signals.end_on_signals()
    _with_docstrings()
    _travel_light()
    from . import streams  # what takes time to load comes after

    streams.open_closed_ones()
    code = _run()
    streams.flush()
    signals.leave(code)


def _with_docstrings() -> None:
    """Pyomo does not work without docstrings: start again, with PYTHONOPTIMIZE=1 in place of 2."""
    if sys.flags.optimize > 1 and os.environ.get("PYTHONOPTIMIZE", "1") != "1":
        os.environ["PYTHONOPTIMIZE"] = "1"
        os.execv(sys.executable, sys.orig_argv)


def _travel_light() -> None:
    """Leave out what a short process has no use of: a twentieth of its time goes into looking for garbage, and some
    into a search of all installed packages for plugins of pydantic."""
    gc.set_threshold(*GARBAGE)
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")


def _run() -> int:
    """The exit code of the command; a bug of ours keeps its traceback."""
    from ..problems.errors import TrajoptError

    try:
        from .app import app
        from .errors import exit_code, tell_error
        from .streams import flushed_output

        try:
            with flushed_output():
                app()
        except TrajoptError as error:  # of standard output, as in --help > /dev/full
            tell_error(error)
            return exit_code(error)
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        import traceback

        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    main()
