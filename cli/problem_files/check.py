"""`trajopt check`: every mistake in problem files, without solving."""

from __future__ import annotations

import sys

from ...transcription.loading import build_checked, load_all
from ..errors import command
from ..options import Files, Set, overrides
from ..output.printing import one_line, plural
from ..streams import piped_text


@command
def check(files: Files, *, set_: Set = None) -> None:
    """Name every mistake in problem files, without solving.

    Example: trajopt check my_problem.yaml
    """
    specs = load_all(files, overrides(set_), piped_text(files))
    build_checked(specs)
    for spec in specs:
        for warning in spec.warnings:
            print(f"warning: {one_line(str(warning))}", file=sys.stderr)
        counts = ((len(spec.states), "state"), (len(spec.controls), "control"), (len(spec.mesh), "mesh"))
        print(f"{spec.file}: no mistakes; " + ", ".join(plural(*count) for count in counts))
