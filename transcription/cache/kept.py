"""What is slow to make: kept in the cache under the name of what it is of, and read from there."""

from __future__ import annotations

import logging
import pickle
from collections.abc import Callable
from typing import Any, TypeVar

from .entries import file_name_of, read_entry, write_entry
from .folder import place
from .identity import identity

LOG = logging.getLogger(__name__)
NOT_PICKLED = pickle.PicklingError, TypeError, AttributeError, RuntimeError
"""What is raised for an object that cannot be pickled, by Python and by SymEngine."""

Made = TypeVar("Made")


def made(kind: str, content: Any, make: Callable[[], Made]) -> Made:
    """What is made of some content, from the cache where it is there.

    kind: what is made.
    content: all that it depends on, besides trajopt, its libraries and the machine; it is compared by its pickle.
    make: makes it, something that is not None; what cannot be pickled is made each time.
    """
    own = name_of_kept(kind, content)
    found: Made | None = load_kept(own)
    if found is None:
        found = make()
        keep(own, found)
    return found


def name_of_kept(kind: str, content: Any) -> str | None:
    """The name of what is made of some content; None where nothing is kept.

    kind, content: as of `made`.
    """
    own = identity() if place() else None
    if own is None:
        return None
    try:
        return file_name_of(own, kind.encode(), pickle.dumps(content, protocol=pickle.HIGHEST_PROTOCOL))
    except NOT_PICKLED as error:
        LOG.info("not looked for in the cache: %s", error)
        return None


def load_kept(own: str | None) -> Any:
    """What was kept under a name; None if it is not there.

    own: as of `name`.
    """
    payload = own and read_entry(own)
    if not payload:
        return None
    try:
        return pickle.loads(payload)
    except Exception as error:  # whatever a pickle raises that is whole, and yet cannot be loaded here
        LOG.info("an entry of the cache cannot be loaded: %s", error)
        return None


def keep(own: str | None, made: Any) -> None:
    """Keep what was made, if that is possible.

    own: as of `name`.
    made: not None.
    """
    if own is None:
        return
    try:
        write_entry(own, pickle.dumps(made, protocol=pickle.HIGHEST_PROTOCOL))
    except NOT_PICKLED as error:
        LOG.info("not kept in the cache: %s", error)
