"""A live line on a terminal while IPOPT iterates; nothing where standard error is no terminal."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager


@contextmanager
def live_line(name: str, meshes: int, wanted: bool) -> Iterator[Callable[[int, dict], None] | None]:
    """The progress callback of `transcription.solve.solve`, or None where nothing should be shown."""
    if not (wanted and sys.stderr.isatty()):
        yield None
        return
    from rich.console import Console

    with Console(stderr=True).status(f"{name}: building") as status:

        def show(mesh: int, record: dict) -> None:
            status.update(
                f"{name}: mesh {mesh + 1} of {meshes}, iteration {record['iteration']}, "
                f"J = {record['objective']:.8g}, infeasibility {record['primal_infeasibility']:.1e}"
            )

        yield show


def print_iteration(mesh: int, record: dict) -> None:
    """One line for each iteration on standard error, for --verbose."""
    if record["iteration"] == 0:
        print(f"mesh {mesh + 1}\n iter  objective        infeasibility  dual        mu", file=sys.stderr)
    print(
        f"{record['iteration']:5d}  {record['objective']:<15.8g}  {record['primal_infeasibility']:<13.2e}  "
        f"{record['dual_infeasibility']:<10.2e}  {record['mu']:.1e}",
        file=sys.stderr,
    )
