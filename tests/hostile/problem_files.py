"""`check`, `solve` and `show` on problem files that are mutated from the shipped ones and those of tests and docs, or
made to be hard."""

from __future__ import annotations

import random
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import NamedTuple

from .hard import HARD
from .mutations import as_text, bases, mutated
from .processes import Run, alone, typed
from .written import bases as written_bases
from .written import overrides

PROCESSOR = {"check": 10, "solve": 20, "show": 10}
"""Seconds of a run. A failed solve spends up to 10 on the search for other starts, and for what has to give way."""
FEW = ["--set", "solver.max_iter=3"]


class Text(NamedTuple):
    """A problem file: its name, its content, and what is typed beside it."""

    name: str
    content: str
    options: Sequence[str] = ()


def texts(count: int, seed: int) -> Iterator[Text]:
    """So many problem files: those that are hard, and then mutations of the shipped ones."""
    yield from (Text(name, content) for name, content in list(HARD.items())[:count])
    yield from mutations(count - len(HARD), seed)


def mutations(count: int, seed: int) -> Iterator[Text]:
    """Mutations of shipped files; the one with number k is the same whatever the count is."""
    known = bases()
    for k in range(count):
        rng = random.Random(f"{seed} {k}")
        name = rng.choice(list(known))
        yield Text(f"{name} {seed} {k}", as_text(mutated(known[name], list(known.values()), rng), rng))


def written(count: int, seed: int) -> Iterator[Text]:
    """Mutations of the files of tests and docs, some with an override beside them; as of `mutations`."""
    known = written_bases()
    for k in range(count):
        rng = random.Random(f"{seed} {k}")
        name = rng.choice(list(known))
        data = mutated(known[name], list(known.values()), rng)
        yield Text(f"{name} {seed} {k}", as_text(data, rng), overrides(data, rng))


def runs(text: Text, folder: Path) -> Iterator[Run]:
    """`check`; then `solve` in a few iterations, which may refuse what `check` refuses only; then `show`.

    `check` refuses more than `solve`: units that do not fit together. Without these it has to accept what is solved.
    """
    (folder / "bad.yaml").write_text(text.content, encoding="utf-8", errors="surrogatepass")
    checked = _run(text, "check", ["check", "bad.yaml", *FEW, *text.options], folder, {0, 2})
    yield checked
    if checked.fault:
        return
    (folder / "out.h5").unlink(missing_ok=True)
    allowed = {0, 1, 4} if checked.code == 0 else {0, 1, 2, 4}
    solved = _run(text, "solve", ["solve", "bad.yaml", *FEW, *text.options, "-q", "-o", "out.h5"], folder, allowed)
    yield solved
    if checked.code != 0 and solved.code != 2:
        yield _run(text, "check", ["check", "bad.yaml", *FEW, *text.options, "--set", "units=off"], folder, {0})
    if (folder / "out.h5").exists():
        yield _run(text, "show", ["show", "out.h5"], folder, {0, 1, 4})
    elif solved.code in {0, 1, 4}:
        yield Run(text.name, "solve", solved.code, "", "error: Traceback: no result was written", 0.0)


def _run(text: Text, name: str, arguments: list[str], folder: Path, codes: set[int]) -> Run:
    run = alone(text.name, name, folder, lambda: typed(arguments), PROCESSOR[name], "bad.yaml")
    run.codes = frozenset(codes)
    return run
