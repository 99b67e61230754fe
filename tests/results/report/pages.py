"""Results and a sweep whose pages are looked at, each made once."""

import json
import re

from branches import BRANCHES
from command_line import solved_once, trajopt

HOSTILE = """
trajopt: 1
name: "<script>alert(1)</script> & \\"quoted\\""
source: "</title><img src=x onerror=alert(2)>"
note: "<b>bold</b>"
parameters:
  k: {value: 2.0, unit: "<u>N</u>", note: "</script><script>alert(3)</script>"}
  w: {value: k**2 + 1}
time: {initial: 0, final: 1}
states:
  x: {unit: "<i>m</i>", rate: v, initial: 0, final: 1}
  v: {unit: m/s, rate: u*k/w, initial: 0, final: 0, lower: -3}
controls: {u: {unit: N, lower: -100, upper: 100}}
objective: {minimize: {integral: u**2}}
mesh: [{method: hermite-simpson, segments: 10}]
"""

EXPERIMENTS = """
trajopt: 1
time: {initial: 0}
states: {c: {rate: -k*c}}
optimize: {k: {lower: 0, upper: 5, guess: 0.5}}
phases:
  long:
    time: {final: 6}
    states: {c: {initial: 4}}
    measurements: {a: {data: {time: [1, 2, 2, 6], c: [2.4, 1.4, 1.5, 0.2]}}}
  short: {time: {final: 2}, states: {c: {initial: 1}}, measurements: {b: {data: {time: [1, 2], c: [0.62, 0.36]}}}}
links: none
mesh: [{method: radau, segments: 4}]
"""

FILES = {"hostile": HOSTILE, "branches": BRANCHES, "experiments": EXPERIMENTS}

SOLVES = {
    "cartpole": ("cartpole", "--segments", "15"),
    "refined": ("bryson_denham", "--refine", "1e-5"),
    "unsolved": ("cartpole", "--segments", "5", "--set", "solver.max_iter=2"),
    "pendulum": ("pendulum", "--segments", "20"),  # no costates, no error bar
    "phases": ("schwartz_two_phase",),
    "biped": ("biped", "--set", "mesh.-1.segments=6"),  # a chain of links
    **{name: (f"{name}.yaml",) for name in FILES},
}


def solved_in(folder):
    """name -> a result file in the folder, each solved once."""

    def solved(name):
        for own, text in FILES.items():
            (folder / f"{own}.yaml").write_text(text)
        told = [folder / own if own.endswith(".yaml") else own for own in SOLVES[name]]
        return solved_once(folder / f"{name}.h5", *told, code=int(name == "unsolved"))

    return solved


def swept_in(folder):
    """The folder of a sweep of twelve cases, two of which are not solved."""
    target = folder / "swept"
    if not target.exists():
        over = ["--over", "controls.u.upper=0.5,4.5,5,6,8,12", "--over", "mesh.0.segments=4,8"]
        run = trajopt("sweep", "block_move_min_force", *over, "-o", target, "-q", "--jobs", "1", "--keep", "full")
        assert run.exit_code == 1, run.output
    return target


def page_of(source, target, *options):
    """The text of the page that `trajopt report` writes of a result or a folder."""
    run = trajopt("report", source, "-o", target, *options)
    assert (run.exit_code, run.stdout) == (0, f"{target}\n"), run.output
    return target.read_text()


def data_of(text):
    """What a page gives its scripts."""
    (found,) = re.findall(r'<script type="application/json" id="data">(.*?)</script>', text, re.DOTALL)
    return json.loads(found)
