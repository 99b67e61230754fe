"""Pictures, one after the other, as a film: a GIF, or an MP4 by ffmpeg."""

from __future__ import annotations

import shutil
import subprocess
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from ...problems.errors import FileError, Mistake, SpecError

LAST_FRAME = 0.8  # seconds that a film rests on its last frame before it begins again


def write_film(path: Path, suffix: str, pictures: Iterator[Image.Image], fps: int, about: Mapping[str, str]) -> None:
    """Write pictures to a file.

    path: of the file.
    suffix: of the format, ".gif" or ".mp4".
    pictures: all of one size.
    fps: pictures a second.
    about: what the file says of itself: Software and Title.

    Raises FileError if ffmpeg fails, SpecError if there is none.
    """
    {".gif": _write_gif, ".mp4": _write_mp4}[suffix](path, pictures, fps, about)


def _write_gif(path: Path, pictures: Iterator[Image.Image], fps: int, about: Mapping[str, str]) -> None:
    *rest, last = pictures
    counted: list[tuple[int, Any]] = sorted(last.getcolors(last.width * last.height) or [], reverse=True)
    palette = np.array([colour for _, colour in counted[:256]], int)  # the last picture has all the colours that matter
    first, *others = map(_indexer(palette), (*rest, last))
    delays = [round(1000 / fps)] * len(rest) + [round(1000 * LAST_FRAME)]
    comment = "; ".join(f"{key}: {value}" for key, value in about.items()).encode()[:255]
    first.save(path, "GIF", save_all=True, append_images=others, duration=delays, loop=0, comment=comment)


def _indexer(palette: np.ndarray) -> Callable[[Image.Image], Image.Image]:
    """A function that puts pictures into the colours of the palette, shape (P, 3): the same, or else the nearest.

    Pillow's own conversion is coarser: it turns white to grey.
    """
    place = np.array([1 << 16, 1 << 8, 1])
    known = np.full(1 << 24, -1, np.int16)  # number of each colour in the palette, filled as colours come

    def indexed(picture: Image.Image) -> Image.Image:
        codes = np.asarray(picture, np.int32) @ place
        new = np.unique(codes[known[codes] < 0])
        distance = (((new[:, None] // place % 256)[:, None] - palette) ** 2).sum(axis=-1)
        known[new] = distance.argmin(axis=1) if len(new) else 0
        result = Image.fromarray(known[codes].astype(np.uint8), "P")
        result.putpalette(palette.ravel().tolist())
        return result

    return indexed


def check_film(path: Path) -> None:
    """Refuse, before any work is done, a .mp4 where there is no ffmpeg. Raises SpecError."""
    if path.suffix.lower() == ".mp4" and shutil.which("ffmpeg") is None:
        what = "MP4 films need the program ffmpeg, which is not installed"
        raise SpecError(Mistake(str(path), what, "install ffmpeg, or give a name that ends with .gif"))


def _write_mp4(path: Path, pictures: Iterator[Image.Image], fps: int, about: Mapping[str, str]) -> None:
    check_film(path)
    shown = list(pictures)
    shown += shown[-1:] * round(LAST_FRAME * fps)
    width, height = (2 * (side // 2) for side in shown[0].size)  # the codec wants even numbers
    raw = b"".join(picture.crop((0, 0, width, height)).tobytes() for picture in shown)
    command = ["ffmpeg", "-y", "-loglevel", "error", "-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}"]
    command += ["-r", str(fps), "-i", "-", "-pix_fmt", "yuv420p", "-metadata", f"comment=Software: {about['Software']}"]
    command += ["-metadata", f"title={about['Title']}", str(path)]
    done = subprocess.run(command, input=raw, capture_output=True, check=False)
    if done.returncode:
        reason = (done.stderr.decode(errors="replace").strip().splitlines() or ["without a reason"])[-1]
        raise FileError(Mistake(str(path), f"ffmpeg failed ({reason})", "give a name that ends with .gif"))
