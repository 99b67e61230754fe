"""Where pictures and pages go."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

from ...problems.errors import FileError, Mistake, SpecError
from ...problems.files import make_folder
from ..streams import refuse_standard_output

PICTURES = (".png", ".pdf", ".svg")


def folder_of(output: str | None) -> Path | None:
    """The folder that -o names, the current one without -o; None if it names a file. out/ is made if it is not there.

    Raises SpecError for standard output.
    """
    refuse_standard_output(output, "this command writes files", "")
    if output is not None and output.endswith(os.sep):
        make_folder(Path(output))
    return Path(output or "") if output is None or Path(output).is_dir() else None


def targets_of(results: Sequence[Path], output: str | None, endings: Sequence[str]) -> list[list[Path]]:
    """For each result the files to write: one for each ending, or one for all that -o names.

    Raises SpecError for standard output, and if two pictures would go to one file that cannot hold them; FileError if
    a folder is missing.
    """
    folder = folder_of(output)
    if folder is not None:
        targets = [[folder / (path.stem + ending) for ending in endings] for path in results]
        flat = [path for paths in targets for path in paths]
        if twice := next((path for path in flat if flat.count(path) > 1), None):
            raise SpecError(Mistake(str(twice), "two of them would go to this file", "do one of them with -o"))
        return targets
    if len(results) > 1:
        raise FileError(
            Mistake(f"-o {output}", f"this is no folder, but there are {len(results)} results", "create it first")
        )
    named = Path(str(output))
    if len(endings) > 1 and named.suffix.lower() != ".pdf":
        raise SpecError(Mistake(f"-o {output}", "one file cannot hold two pictures", "give a .pdf, or a folder"))
    return [[named]]
