"""`trajopt cache`: what is kept for the next solve, and how to be rid of it."""

from __future__ import annotations

import json
from typing import Annotated

import typer

from ...problems.errors import FileError, Mistake, SpecError
from ...transcription.cache.entries import LIMIT, clear, entries
from ...transcription.cache.folder import OFF, SWITCH, place
from ..errors import command
from ..options import Json
from ..output.printing import print_field

CLEAR = "clear"
What = Annotated[str | None, typer.Argument(metavar=f"[{CLEAR}]", help=f"'{CLEAR}' deletes all of it.")]


@command
def cache(what: What = None, json_: Json = False) -> None:
    """Tell what is kept for the next solve, or delete it.

    Example: trajopt cache clear
    """
    if what not in (None, CLEAR):
        raise SpecError(
            Mistake(f"cache {what}", "there is no such action", f"write trajopt cache or trajopt cache {CLEAR}")
        )
    folder = place()
    if folder is None:
        raise SpecError(Mistake("cache", f"it is off, as {SWITCH}={OFF} says", f"unset {SWITCH}"))
    try:
        gone = clear() if what else 0
        left = [own.size for own in entries() if not own.name.startswith(".")]
    except FileNotFoundError:
        gone, left = 0, []
    except OSError as error:
        why = error.strerror or str(error)
        raise FileError(
            Mistake(str(folder), f"it is not used: {why}", f"mend that, or name another by {SWITCH}")
        ) from error
    if json_:
        print(json.dumps({"folder": str(folder), "entries": len(left), "bytes": sum(left), "deleted": gone}))
        return
    print_field("folder", str(folder))
    if what:
        print_field("deleted", str(gone))
    print_field("entries", str(len(left)))
    print_field("size", f"{sum(left) / 1e6:.1f} MB of at most {LIMIT / 1e6:.0f}")
