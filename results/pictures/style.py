"""How pictures look, and how they are saved: colours, line styles, sizes, the mark that says who drew a file.

The colours are those of Okabe and Ito (2008), which colour-blind readers tell apart; line styles, markers and lightness
carry the same differences in grey print.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil
from pathlib import Path
from typing import Any

import matplotlib
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec
from matplotlib.ticker import Formatter

from ...problems.files import check_ours, check_suffix, replacing
from ...problems.lean.records import dataclass
from ...problems.lean.versions import version
from ...problems.text import shorten

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
BLUE, VERMILION, PURPLE, GREY = "#0072B2", "#D55E00", "#CC79A7", "#767676"
VIOLATED = "#B00020"  # of a bound, as nothing else is
KIND_COLOURS = {
    "state": BLUE,
    "control": VERMILION,
    "algebraic": GREEN,
    "output": ORANGE,
    "path": SKY,
    "costate": PURPLE,
}
COLOURS = {
    "black": BLACK,
    "orange": ORANGE,
    "sky": SKY,
    "green": GREEN,
    "blue": BLUE,
    "vermilion": VERMILION,
    "purple": PURPLE,
    "grey": GREY,
}
"""The colours that a drawing may name."""

TIME_COLOURS = "viridis"  # from blue and dark to yellow and light, as in the paper's Figure 9

PARTS = {"cart": BLUE, "pole": BLACK, "tip": VERMILION, "ground": "#763E0C", "obstacle": "#B8B8B8"}
"""Role of a shape -> its colour, where the file gives none."""

DPI = 150
LETTER = 0.074  # inches, the mean width of a letter of a title
LOOK: Any = {
    "font.size": 9.0,
    "axes.titlesize": 9.0,
    "axes.labelsize": 9.0,
    "xtick.labelsize": 8.0,
    "ytick.labelsize": 8.0,
    "legend.fontsize": 8.0,
    "figure.titlesize": 11.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": "#E4E4E4",
    "grid.linewidth": 0.6,
    "lines.linewidth": 1.4,
    "legend.frameon": False,
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "pdf.fonttype": 42,  # text stays text, not outlines
    "svg.fonttype": "none",
    "svg.hashsalt": "trajopt",  # the same result gives the same file
    "font.family": "sans-serif",
    "agg.path.chunksize": 10_000,
}

_MARKS = {  # suffix -> the first bytes of such a file, and what ours holds besides
    ".png": (b"\x89PNG", b"Software\0trajopt"),
    ".pdf": (b"%PDF", b"/Creator (trajopt"),
    ".svg": (b"<?xml", b"trajopt "),
    ".gif": (b"GIF8", b"Software: trajopt"),
    ".mp4": (b"", b"Software: trajopt"),
}


class Numbers(Formatter):
    """Numbers beside an axis, each written out: a common factor above the axis would push the panel's title away."""

    def __call__(self, value: float, position: int | None = None) -> str:
        return self.format_ticks([value])[0]

    def format_ticks(self, values: Sequence[float]) -> list[str]:
        size = np.abs(values).max(initial=1e-300)
        step = np.abs(np.diff(values)).min(initial=size) or size
        digits = 3 + max(int(np.ceil(np.log10(size / step))), 0)
        texts = ("0" if abs(value) < 1e-9 * step else f"{value:.{digits}g}" for value in values)
        return [text.replace("-", "\N{MINUS SIGN}") for text in texts]


def look() -> Any:
    """A context in which figures are made and saved in this style; Matplotlib's own settings come back after it."""
    return matplotlib.rc_context(LOOK)


def plain_label(text: str, limit: int = 80) -> str:
    """A text of the user's as a label: one line, not too long, and no mathematics for Matplotlib to parse."""
    return shorten(" ".join(str(text).split()), limit).replace("$", r"\$")


def labelled(name: str, unit: str, width: float = 100.0) -> str:
    """ "name [unit]" as a label; what has no unit is given none.

    name: of a quantity, in the user's words.
    unit: of the quantity, "" or "1" for none.
    width: inches; a label that is wider stands on two lines.
    """
    if unit in ("", "1"):
        return plain_label(name, 50)
    unit = plain_label(unit.replace("/s/s", "/s²").replace("^2", "²").replace("^3", "³").replace("*", "·"), 30)
    label = f"{plain_label(name, 50)} [{unit}]"
    return label if len(label) * LETTER <= width else f"{plain_label(name, 50)}\n[{unit}]"


def width_of(ax: Axes) -> float:
    """The width of axes in inches."""
    figure = ax.get_figure(root=True)
    assert figure is not None
    return float(ax.get_position().width * figure.get_figwidth())


RAISED = 10.0
"""Points between axes and a title that small texts stand below."""


def set_title(ax: Axes, label: str, note: str = "", *, raised: bool = False) -> None:
    """A title at the left of the axes, and a small note beside it.

    ax: the axes, with their final width.
    label: the title, of one line or more.
    note: stands at the right if there is room, else at the end of the title; "" for none.
    raised: whether there is a line of small texts below it, such as the names of phases.
    """
    pad = RAISED if raised else None  # Matplotlib's own
    width = width_of(ax)
    room = width - LETTER * max(map(len, label.split("\n")))
    if note and len(note) * 0.83 * LETTER > room:
        label, note = f"{label}\n{note}", ""
    ax.set_title(label, loc="left", pad=pad)
    ax.set_title(note, loc="right", color=GREY, fontsize="small", pad=pad)


@dataclass(frozen=True)
class Frame:
    """Margins of a figure and gaps between its panels, in inches.

    They are fixed: to measure all texts first takes as long as to draw the figure.
    """

    left: float = 0.85
    right: float = 0.2
    top: float = 0.85
    bottom: float = 0.9
    across: float = 0.85
    down: float = 0.45

    def figure(self, rows: Sequence[float], columns: int, width: float) -> tuple[Figure, GridSpec]:
        """A figure of panels, and its grid.

        rows: height of each row, inches.
        columns: the number of columns.
        width: of each panel, inches.
        """
        count = len(rows)
        inner = (columns * width + (columns - 1) * self.across, sum(rows) + (count - 1) * self.down)
        W, H = inner[0] + self.left + self.right, inner[1] + self.top + self.bottom
        figure = Figure(figsize=(W, H))
        grid = figure.add_gridspec(
            count, columns, height_ratios=rows,
            left=self.left / W, right=1 - self.right / W, top=1 - self.top / H, bottom=self.bottom / H,
            wspace=self.across / width, hspace=self.down / (sum(rows) / count),
        )  # fmt: skip
        return figure, grid


def head(figure: Figure, lines: Sequence[str], colour: str) -> None:
    """The title of a figure, above the panels.

    figure: with its final height.
    lines: of the title, from the top.
    colour: any of Matplotlib's.
    """
    figure.suptitle("\n".join(lines), color=colour, fontsize=10, y=1 - 0.12 / figure.get_figheight(), va="top")


def legend(figure: Figure, order: Sequence[str]) -> None:
    """One legend for all panels, at the foot of the figure; entries stand in the given order."""
    entries: dict[str, Any] = {}
    for ax in figure.axes:
        for handle, label in zip(*ax.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    labels = sorted(entries, key=order.index)
    wide = sum(len(label) * LETTER * 0.9 + 0.55 for label in labels)
    rows = ceil(wide / figure.get_figwidth())
    style: dict[str, Any] = {"ncols": ceil(len(labels) / rows), "borderaxespad": 0.3}
    figure.legend([entries[label] for label in labels], labels, loc="lower center", **style)


def mark(title: str) -> dict[str, str]:
    """What is written into a picture about itself. No date: the same result gives the same file."""
    return {"Software": f"trajopt {version('trajopt')}", "Title": title}


def check_picture(path: Path, suffixes: Sequence[str], force: bool = False) -> None:
    """Refuse, before any work is done, a path that no picture could or should be written to.

    path: of the picture to come; an earlier picture of trajopt's may be replaced.
    suffixes: those that the path may have, in lower case, as ".png".
    force: whether any other file may be replaced too.

    Raises SpecError for a suffix that is none of `suffixes`, FileError otherwise.
    """
    check_suffix(path, "picture", suffixes, f"end the name with {' or '.join(suffixes)}")
    check_ours(path, force, drawn_by_us, "was not drawn by trajopt")


def drawn_by_us(path: Path) -> bool:
    """Whether the picture says that trajopt drew it. Raises OSError if it cannot be read."""
    start, software = _MARKS[path.suffix.lower()]
    content = path.read_bytes()
    return content.startswith(start) and software in content


def save_figure(figures: Sequence[Figure], path: Path, title: str) -> None:
    """Write figures to a .pdf, one a page, or one figure to a .png or a .svg.

    figures: in the order of the pages; exactly one for a .png or a .svg.
    path: of the picture; its suffix says the format.
    title: written into the file, not drawn.

    Raises FileError.
    """
    about = mark(title)
    with look(), replacing(path) as temporary:
        if path.suffix.lower() == ".png":
            (figure,) = figures
            figure.savefig(temporary, format="png", metadata=about)
            return
        if path.suffix.lower() == ".svg":
            (figure,) = figures
            figure.savefig(
                temporary, format="svg", metadata={"Creator": about["Software"], "Title": title, "Date": None}
            )
            return
        from matplotlib.backends.backend_pdf import PdfPages

        told: dict[str, Any] = {"Creator": about["Software"], "Title": title, "CreationDate": None}
        with PdfPages(temporary, metadata=told) as pages:
            for figure in figures:
                pages.savefig(figure)
