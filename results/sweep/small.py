"""The small result of a case as bytes: its record and what it leaves for its neighbours, each part with a check sum."""

from __future__ import annotations

import json
import zipfile
from io import BytesIO
from typing import Any

import numpy as np

from ...problems.problem import Guess
from ...transcription.engines.outcome import Start
from ...transcription.starts.near import Near
from .case import Left

MULTIPLIERS = ("y", "z_lower", "z_upper")

BROKEN = (
    OSError, ValueError, KeyError, EOFError, zipfile.BadZipFile, NotImplementedError, TypeError, AttributeError,
    RecursionError, MemoryError,
)  # fmt: skip
"""What `unpacked` may raise."""


def packed(record: bytes, left: Left) -> bytes:
    """The content of the file.

    record: as JSON.
    left: by the case.
    """
    arrays: dict[str, Any] = {"record": np.frombuffer(record, np.uint8)}
    heads = {}
    for name, guess in left.curves.items():
        heads[name] = [guess.initial_time, guess.final_time, dict(guess.parameters), list(guess.values)]
        arrays[f"{name}|s"] = guess.s
        arrays[f"{name}|values"] = np.array(list(guess.values.values()))
    arrays["curves"] = np.frombuffer(json.dumps(heads).encode(), np.uint8)
    if left.near:
        arrays["|objective"] = np.array(left.near.objective)
        arrays |= {f"|{name}": getattr(left.near.start, name) for name in MULTIPLIERS}
    stream = BytesIO()
    np.savez(stream, **arrays)
    return stream.getvalue()


def unpacked(content: bytes) -> tuple[dict[str, Any], Left]:
    """The way back. Raises one of BROKEN if a part is missing or differs from its check sum."""
    with zipfile.ZipFile(BytesIO(content)) as parts:
        if sum(part.file_size for part in parts.infolist()) > len(content):
            raise ValueError("its parts are larger than it: nothing here is compressed")
        if parts.testzip() is not None:
            raise ValueError("a check sum is wrong")
    with np.load(BytesIO(content), allow_pickle=False) as arrays:
        record, heads = (json.loads(arrays[name].tobytes()) for name in ("record", "curves"))
        curves = {
            name: Guess(
                t0, tF, arrays[f"{name}|s"], dict(zip(names, arrays[f"{name}|values"], strict=True)), parameters
            )
            for name, (t0, tF, parameters, names) in heads.items()
        }
        if "|y" not in arrays:
            return record, Left(curves)
        start = Start(*(arrays[f"|{name}"].astype(float).ravel() for name in MULTIPLIERS))
        points = tuple(curve.s for curve in curves.values())
        return record, Left(curves, Near(points, float(arrays["|objective"]), start))
