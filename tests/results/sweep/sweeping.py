"""A small sweep whose cases are solved in this process."""

import csv
from concurrent.futures import Future
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path

from trajopt.results.sweep import dataset, run, tables
from trajopt.results.sweep.axes import parse_axis
from trajopt.results.sweep.case import solve_case
from trajopt.results.sweep.plan import grid
from trajopt.results.sweep.store import Store, about

TEXT = """
trajopt: 1
name: push
parameters: {l: {value: 1, unit: m}, T: {value: 1, unit: s}}
time: {initial: 0, final: T}
states:
  x: {unit: m, rate: v, initial: 0, final: l}
  v: {unit: m/s, rate: u, initial: 0, final: 0}
controls: {u: {unit: m/s^2, lower: -20, upper: 20}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 4}]
"""


PLAN = grid([parse_axis("parameters.l=1,2,3"), parse_axis("mesh.0.method=trapezoid,hermite-simpson")])


class Inline:
    """An engine in this process; `deaths`: how often the worker of a case dies; `backwards`: the last task first."""

    waits, capacity = True, 2

    def __init__(self, deaths=(), backwards=False):
        self.deaths, self.backwards, self.tasks, self.held = dict(deaths), backwards, [], []

    def submit(self, task):
        self.tasks.append(task)
        future = Future()
        if self.deaths.get(task.number, 0):
            self.deaths[task.number] -= 1
            future.set_exception(BrokenProcessPool("killed"))
        else:
            future.set_result(solve_case(task))
        return future

    def stop(self):
        pass

    def close(self):
        pass


def swept(
    folder="s", plan=PLAN, engine=None, *, text=TEXT, full=False, chain=False, stop_after=None, shard=None, **how
):
    """A sweep from its beginning to its end, or as far as `stop_after` cases; gives the records and the tasks."""
    engine, ended = engine or Inline(), []
    store = Store(Path(folder), plan, shard)
    store.open(about(plan, text, "push.yaml", [], chain), **how)
    try:
        job = run.Job(text, "push.yaml", (), "trajopt sweep push.yaml", full, chain)
        _, missing = run.todo(plan, store, full, shard)
        run.run(plan, store, engine, job, missing, stop=lambda: stop_after is not None and len(ended) >= stop_after,
                report=lambda record: record and ended.append(record["case"]))  # fmt: skip
        records = store.refreshed()
        tables.write_table(Path(folder) / "index.csv", plan.paths, records)
        dataset.write_arrays(Path(folder) / "sweep.h5", plan, records, {"units": {"l": "m", "time": "s", "x": "m"}})
    finally:
        store.close()
    return records, [task.number for task in engine.tasks]


def table(folder="s"):
    """index.csv without the seconds."""
    with open(Path(folder) / "index.csv", newline="") as file:
        return [{key: value for key, value in row.items() if key != "seconds"} for row in csv.DictReader(file)]
