"""`trajopt table`: curves of result files -> CSV or Parquet."""

from __future__ import annotations

import os
import sys
from math import inf
from pathlib import Path
from typing import Annotated

import typer

from ...problems.errors import Mistake, SpecError
from ...problems.files import check_writable, make_folder
from ..errors import command
from ..options import Force, Results
from ..output.printing import one_line

Output = Annotated[
    str | None, typer.Option("-o", "--output", metavar="FILE", help="Name ending with .csv or .parquet; - prints CSV.")
]
Dense = Annotated[bool, typer.Option("--dense", help="On the fine grid of the file, not at the points of the mesh.")]
Every = Annotated[
    float | None,
    typer.Option("--every", metavar="STEP", help="On an even grid of times, STEP apart.", show_default=False),
]
Units = Annotated[bool, typer.Option("--units", help="Write units beside the names: x [m].")]


@command
def table(
    results: Results,
    *,
    output: Output = None,
    dense: Dense = False,
    every: Every = None,
    units: Units = False,
    force: Force = False,
) -> None:
    """Write the curves of results as a table, one row a time.

    Columns are states, controls, outputs and costates.

    Example: trajopt table cartpole.h5 --every 0.01 -o swing.csv

    Without -o the table goes to <name of the result>.csv in the current folder. An even grid begins at the initial time
    and ends at the final one; it takes the values of the method's own interpolants. Several results are stacked, and
    the first column tells the file. Parquet needs pandas and pyarrow.
    """
    from ...results.tabular.columns import DENSE, POINTS, stacked_table
    from ...results.tabular.save import check_table_format, csv_text, save_table

    if every is not None and not 0 < every < inf:
        remedy = "write one in the unit of time, such as 0.01"
        raise SpecError(Mistake("--every", f"the step {every:g} is no positive number", remedy))
    if every is not None and dense:
        raise SpecError(Mistake("--dense", "with --every the times are even", "leave out one of the two options"))
    times = every if every is not None else DENSE if dense else POINTS
    if output == "-":
        print(csv_text(stacked_table(results, times), units), end="")
        return
    if output is None and len(results) > 1:
        what = f"there are {len(results)} results for one table"
        raise SpecError(Mistake("-o", what, "name the table, as -o all.csv"))
    path = Path(output or f"{results[0].stem}.csv")
    if output is not None and output.endswith(os.sep):
        make_folder(path)
    if path.is_dir():
        path /= f"{results[0].stem}.csv"
    check_table_format(path)
    check_writable(path, force)
    found = stacked_table(results, times)
    save_table(found, path, units)
    rows = len(found["time"].values)
    print(one_line(f"{path}: {rows} rows, {len(found)} columns"), file=sys.stderr)
    print(path)
