"""trajopt: trajectory optimization from a problem file."""

import os
import signal


def main() -> None:
    """Run the command line. Ctrl-C while it is still being loaded ends the process with exit code 130 and no word."""
    if at_once := signal.getsignal(signal.SIGINT) is signal.default_int_handler:  # else it is ignored, as under nohup
        signal.signal(signal.SIGINT, lambda number, frame: os._exit(130))

    from .app import app

    if at_once:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    app()


if __name__ == "__main__":
    main()
