"""Damage of the bytes of a result file, of the problem that it holds, and files that are none."""

from __future__ import annotations

import json
import os
import random
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import h5py
import numpy as np

DEEP = 5000
VALUES: list[Any] = [
    None, True, -1, 0, 1e308, 10**30, 1e-320, "", "x", "1/0", "\x1b[31m", "__import__('os')", "x" * 20_000, [], {}, [1],
    {"a": 1}, [[[]]], "final", "t" * 300, "sqrt(-1)", "(" * 300, 10**400,
]  # fmt: skip
"""What a leaf of the stored problem becomes."""


def flipped(rng: random.Random) -> Callable[[Path], None]:
    """Some bytes are others."""
    count, seed = rng.choice([1, 1, 1, 2, 8, 64]), rng.random()

    def apply(path: Path) -> None:
        own, content = random.Random(seed), bytearray(path.read_bytes())
        for _ in range(count):
            content[own.randrange(len(content))] ^= 1 << own.randrange(8)
        path.write_bytes(content)

    return apply


def flipped_head(rng: random.Random) -> Callable[[Path], None]:
    """A byte among the first, where HDF5 says how the rest is made, is another."""
    place, bit = rng.randrange(4096), rng.randrange(8)

    def apply(path: Path) -> None:
        content = bytearray(path.read_bytes())
        content[place % len(content)] ^= 1 << bit
        path.write_bytes(content)

    return apply


def cut(rng: random.Random) -> Callable[[Path], None]:
    """The end is missing, or a part in the middle."""
    share, middle, much = rng.random(), rng.random() < 0.5, rng.randrange(1, 5000)

    def apply(path: Path) -> None:
        content, place = path.read_bytes(), int(share * path.stat().st_size)
        path.write_bytes(content[:place] + (content[place + much :] if middle else b""))

    return apply


def blanked(rng: random.Random) -> Callable[[Path], None]:
    """A part is zeros, or rubbish."""
    share, much, rubbish = rng.random(), rng.choice([8, 512, 4096]), rng.random() < 0.5
    filling = rng.randbytes(much) if rubbish else bytes(much)

    def apply(path: Path) -> None:
        content = path.read_bytes()
        place = int(share * len(content))
        path.write_bytes((content[:place] + filling + content[place + much :])[: len(content)])

    return apply


BYTES = {"flipped": flipped, "flipped head": flipped_head, "cut": cut, "blanked": blanked}


def _leaves(node: Any, path: tuple = ()) -> Iterator[tuple]:
    if isinstance(node, dict | list):
        for key, value in list(node.items() if isinstance(node, dict) else enumerate(node)):
            yield (*path, key)
            yield from _leaves(value, (*path, key))


def with_problem(change: Callable[[str], str]) -> Callable[[Path], None]:
    """The stored problem is another text."""

    def apply(path: Path) -> None:
        with h5py.File(path, "r+") as file:
            text = file["spec/full"].asstr()[()]
            del file["spec/full"]
            file["spec/full"] = change(text)

    return apply


def problems(rng: random.Random) -> Callable[[Path], None]:
    """A value of the stored problem is another, or missing."""
    seed, value = rng.random(), rng.choice([*VALUES, ...])

    def change(text: str) -> str:
        data = json.loads(text)
        *parents, last = random.Random(seed).choice(list(_leaves(data)))
        node = data
        for key in parents:
            node = node[key]
        if value is ...:
            del node[last]
        else:
            node[last] = value
        return json.dumps(data)

    return with_problem(change)


TEXTS = {
    "empty": "", "no json": "{", "list": "[]", "number": "1", "deep list": "[" * DEEP + "]" * DEEP,
    "deep": '{"reference":' * DEEP + "1" + "}" * DEEP, "reference": '{"reference": {"objective": "x"}}',
    "reference list": '{"reference": [1]}', "nan": '{"reference": {"objective": NaN, "tolerance": 1}}',
    "null": "null", "nothing": "{}", "digits": '{"reference": ' + "9" * 5000 + "}",
}  # fmt: skip


def _replaced(make: Callable[[Path], object]) -> Callable[[Path], None]:
    """What is there is none of ours."""

    def apply(path: Path) -> None:
        path.unlink()
        make(path)

    return apply


def _other_hdf5(path: Path) -> None:
    with h5py.File(path, "w") as file:
        file["x"] = np.arange(3)


def _user_block(path: Path) -> None:
    path.write_bytes(bytes(512) + b"rubbish")


FOREIGN: dict[str, Callable[[Path], None]] = {
    "nothing": _replaced(lambda path: path.write_bytes(b"")),
    "text": _replaced(lambda path: path.write_text("hello\n")),
    "folder": _replaced(Path.mkdir), "fifo": _replaced(os.mkfifo), "missing": _replaced(lambda path: None),
    "device": _replaced(lambda path: path.symlink_to("/dev/zero")),
    "loop": _replaced(lambda path: path.symlink_to(path)),
    "signature": _replaced(lambda path: path.write_bytes(b"\x89HDF\r\n\x1a\n" + bytes(100))),
    "other": _replaced(_other_hdf5), "zeros": _replaced(lambda path: path.write_bytes(bytes(100_000))),
    "user block": _replaced(_user_block),
}  # fmt: skip
