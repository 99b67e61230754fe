"""The problems that ship with trajopt, by name."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

from .errors import FileError, Mistake, SpecError
from .files import check_writable, write_whole
from .lean.records import dataclass
from .text import did_you_mean, shorten

_FOLDER = Path(__file__).parent
_NAME = re.compile(r"^name:.*(?:\n+[ \t]+\S.*)*", re.MULTILINE)
"""The name of a problem in its file, with the lines on which it goes on."""

TEMPLATE = "template"


def shipped() -> dict[str, Path]:
    """Name -> file of every shipped problem, in alphabetical order."""
    return {path.stem: path for path in sorted(_FOLDER.glob("*.yaml")) if path.stem != TEMPLATE}


@dataclass(frozen=True)
class Listed:
    """What the list of the shipped problems says of one.

    reference: the known value of the objective, None if there is none.
    """

    name: str
    tags: tuple[str, ...]
    source: str
    reference: float | None


def listed() -> dict[str, Listed]:
    """Name -> what is listed of every shipped problem, in alphabetical order.

    Nothing is checked: to load all of them takes twenty times as long, and the tests do that.
    """
    from .yaml.document import read_document

    return {
        name: _listed(read_document(path.read_text(encoding="utf-8"), path.name).data)
        for name, path in shipped().items()
    }


def _listed(data: Any) -> Listed:
    known = data.get("reference")
    return Listed(data["name"], tuple(data["tags"]), data["source"], known and float(known["objective"]))


def find_problem(name: str) -> Path:
    """The file that a user means: a path that exists, with or without its .yaml, or the name of a shipped problem.

    The shipped "cartpole" goes before a file cartpole.yaml, which is named in full. Raises FileError if it is none of
    them, SpecError for an override in the place of a file.
    """
    path = Path(name)
    if _exists(path):
        return path
    known = shipped()
    if path.parent == Path() and path.name.removesuffix(".yaml") in known:
        return known[path.name.removesuffix(".yaml")]
    beside = path.with_name(f"{path.name}.yaml")
    if not path.suffix and beside.is_file():
        return beside
    if re.match(r"[A-Za-z_][\w.*\[\]-]*=", name):
        what = "this is no file, but an override, and each of them has an option of its own"
        raise SpecError(Mistake(name, what, f"write --set {name}"))
    if re.fullmatch(r"-?[\d.]+(e-?\d+)?", name):
        what = "this is no file, but looks like the value of an override, which has = before it"
        raise SpecError(Mistake(name, what, f"write --set PATH={name}, as --set parameters.u_max=15"))
    if path.parent != Path():
        raise FileError(Mistake(name, "there is no such file", f"look into {path.parent}"))
    remedy = did_you_mean(path.name.removesuffix(".yaml"), known, always="trajopt list shows those that are shipped")
    raise FileError(Mistake(name, "there is no such file and no shipped problem of that name", remedy))


def _exists(path: Path) -> bool:
    """Whether there is a file or folder of that name. Raises FileError for what cannot be the name of one."""
    try:
        return path.exists()
    except (OSError, ValueError) as error:  # too long, in a folder that may not be looked into, a zero in it
        reason = (getattr(error, "strerror", "") or str(error)).lower()
        what = f"this cannot be the name of a file ({reason})"
        raise FileError(Mistake(shorten(str(path)), what, "check its name and its folder")) from error


def start_new(name: str, source: str = TEMPLATE, force: bool = False) -> Path:
    """Write NAME.yaml in the current folder, a copy of a shipped problem or of the commented template.

    The CSV files that the problem names are copied beside it.

    name: of the file, with or without its suffix, and of the problem in it.
    source: the name of a shipped problem, a path, or "template".
    force: whether an existing file is replaced.

    Raises FileError if it cannot be written, if it exists and `force` is not set, or if there is no such source, and
    SpecError if that is no text.
    """
    from .load import read_text

    target = Path(name if name.endswith((".yaml", ".yml")) else f"{name}.yaml")
    origin = _FOLDER / f"{TEMPLATE}.yaml" if source == TEMPLATE else find_problem(source)
    check_writable(target, force)
    text = read_text(origin)
    copies = {origin.parent / file: target.parent / file for file in files_of(text)}
    for data, copy in copies.items():
        if data.is_file() and not (copy.exists() and copy.read_bytes() == data.read_bytes()):
            copy.parent.mkdir(parents=True, exist_ok=True)
            check_writable(copy, force)
    title = target.stem if re.fullmatch(r"[A-Za-z][\w-]*", target.stem) else json.dumps(target.stem)
    text = _NAME.sub(lambda _: f"name: {title}", text, count=1)
    write_whole(target, f"{text.rstrip()}\n")
    for data, copy in copies.items():
        if data.is_file():
            write_whole(copy, data.read_bytes())
    return target


def files_of(text: str) -> list[str]:
    """The CSV files that a problem file names, in its folder; none of one that cannot be read."""
    from .yaml.document import read_document

    try:
        data = read_document(text, "").data
    except SpecError:
        return []
    found: list[str] = []
    waiting: list[object] = [data]
    while waiting:
        node = waiting.pop()
        if isinstance(node, dict):
            found += [own for key, own in node.items() if key == "file" and isinstance(own, str)]
        waiting += node.values() if isinstance(node, dict) else node if isinstance(node, list) else ()
    plain = (own for own in dict.fromkeys(found) if not Path(own).is_absolute() and ".." not in Path(own).parts)
    return list(plain)
