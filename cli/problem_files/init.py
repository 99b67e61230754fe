"""`trajopt init`: a problem file to start from."""

from __future__ import annotations

from typing import Annotated

import typer

from ..errors import command
from ..options import Force


@command
def init(
    name: Annotated[str, typer.Argument(metavar="NAME", help="Name of the new problem; the file is NAME.yaml.")],
    *,
    source: Annotated[str, typer.Option("--from", metavar="NAME", help="Copy this shipped problem.")] = "template",
    force: Force = False,
) -> None:
    """Write a commented problem file to start from.

    Example: trajopt init my_problem --from cartpole
    """
    from ...problems.catalog import start_new

    path = start_new(name, source, force)
    print(f"{path}: edit it, then run: trajopt solve {path}")
