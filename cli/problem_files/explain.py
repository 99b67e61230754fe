"""`trajopt explain`: what of a problem would have to give way for it to have a solution."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from ...problems.errors import Mistake, SpecError
from ...transcription.loading import build_checked, load_all, located
from ..errors import NOT_SOLVED, command
from ..options import Json, Method, Quiet, Segments, Set, overrides
from ..output.printing import cell, print_json, print_table, print_title
from ..output.progress import live_text

if TYPE_CHECKING:
    from ...problems.quantities import Range
    from ...problems.schema.spec import Spec
    from ...transcription.failure.relax import Explanation, Relaxation

Sources = Annotated[
    list[str],
    typer.Argument(metavar="FILE|NAME|RESULT...", help="Problem files, shipped names, or results.", show_default=False),
]
COLUMNS = ("give way", "from", "to", "unit", "when")


@command
def explain(
    sources: Sources,
    *,
    set_: Set = None,
    method: Method = None,
    segments: Segments = None,
    json_: Json = False,
    quiet: Quiet = False,
) -> None:
    """Say whether all constraints can hold, or what must give way.

    Dynamics stay as they are; ends, times, constraints and bounds may be relaxed, each by itself as little as possible.
    Exit code 1 if something has to give way.

    Example: trajopt explain cartpole --set parameters.u_max=2
    """
    from ...transcription.failure.relax import explain as run
    from ...transcription.settings import meshes_of, schedule_of

    specs = [spec for source in sources for spec in _specs(source, overrides(set_, method, segments))]
    holds = True
    for spec, problems in zip(specs, build_checked(specs), strict=True):
        with located(spec), live_text(f"explaining {spec.name}", not quiet):
            explanation = run(problems[0], meshes_of(problems[0], schedule_of(spec)[0]))
        holds &= explanation.feasible
        if json_:
            print_json({"problem": spec.name, **_told(explanation)})
        elif not quiet:
            _print(spec.name, explanation)
    if not holds:
        raise typer.Exit(NOT_SOLVED)


def _specs(source: str, given: list[str]) -> list[Spec]:
    """The spec of a problem file, or of the problem that a result holds."""
    if Path(source).suffix != ".h5":
        return load_all([source], given)
    from ...results.file.reload import stored_spec

    if given:
        what = "a result holds its problem as it was solved"
        raise SpecError(Mistake(source, what, "give the problem file with --set, --method or --segments"))
    return [stored_spec(Path(source))]


def _print(name: str, explanation: Explanation) -> None:
    if not explanation.settled:
        print_title(f"{name}: it is not known whether the constraints can all hold: the search failed", False)
    elif explanation.feasible:
        print_title(f"{name}: the constraints can all hold", True)
    else:
        print_title(f"{name}: the constraints cannot all hold", False)
        print(f"these would do {'each by itself' if explanation.alternatives else 'together, none does by itself'}:")
        rows = [_cells(own) for own in explanation.alternatives or explanation.together]
        print_table(COLUMNS, rows, right=("from", "to"))


def _cells(own: Relaxation) -> list[str]:
    when = "" if own.start is None or own.end is None else f"t = {own.start:.6g} to {own.end:.6g}"
    return [own.what, _range(own.before), _range(own.after), "" if own.unit == "1" else own.unit, when]


def _range(own: Range) -> str:
    """One number, or "lower, upper" with nothing where there is no bound."""
    if own.fixed:
        return cell(own.lower, ".6g")
    return ", ".join(cell(end, ".6g") or "-" for end in (own.lower, own.upper))


def _told(explanation: Explanation) -> dict[str, Any]:
    return {
        "settled": explanation.settled,
        "feasible": explanation.feasible if explanation.settled else None,
        "alternatives": [_record(own) for own in explanation.alternatives],
        "together": [_record(own) for own in explanation.together],
    }


def _record(own: Relaxation) -> dict[str, Any]:
    before, after = ([r.lower, r.upper] for r in (own.before, own.after))
    return {**vars(own), "before": before, "after": after, "text": str(own)}
