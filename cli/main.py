"""trajopt: trajectory optimization from a problem file."""

from __future__ import annotations

from . import signals


def main() -> None:
    """Run the command line.

    The process ends here, not by Python's own way out, which takes the handlers of signals away before it has ended.
    """
    signals.end_on_signals()
    from . import streams  # what takes time to load comes after

    streams.open_closed_ones()
    code = _run()
    streams.flush()
    signals.leave(code)


def _run() -> int:
    """The exit code of the command; a bug of ours keeps its traceback."""
    try:
        from .app import app

        app()
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    except BaseException:
        import traceback

        traceback.print_exc()
        return 1
    return 0


if __name__ == "__main__":
    main()
