"""How often does `trajopt verify` fail a good result, and how often does it pass a bad one? Tables in Markdown.

    python tests/benchmarks/verify_alarms.py [--folder DIR [--resume]] [--only WORD] [--workers N]

Good results: the shipped problems and those of `known_optima`, each by several methods, refined as by default; and the
shipped ones as they are. One counts as good if it is solved to its tolerance and, where the optimum is known, near it.
Bad results: good ones that were tampered with (`tampering`), and extremals that are no optima (WRONG). A check that
fails on a good result is a false alarm; a bad result that passes is a miss. Each case is told as soon as it is judged,
in an order that makes those so far a sample of all; the tables come at the end. --folder keeps the results of the
solves and the verdicts there: another run only verifies, and with --resume only what has no verdict yet; --only takes
the cases whose name holds this word.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import asdict, dataclass, field
from pathlib import Path
from zlib import crc32

os.environ.setdefault("OMP_NUM_THREADS", "1")
sys.path.insert(0, str(Path(__file__).parent))
import tampering
from known_optima import KNOWN, RANGE

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load, load_text
from trajopt.results.file.write import write
from trajopt.results.verify import verify
from trajopt.transcription.continuation import solve_spec

METHODS = {"radau": 10, "hermite-simpson": 20, "trapezoid": 40, "gauss": 10, "runge-kutta-4": 20}
"""Segments of the first mesh."""

LEFT_OUT = ("template", "biped_supplement")  # an exercise for the reader; the biped once more
ONLY_AS_SHIPPED = ("biped", "pendulum")  # large; without controls
SCHEDULED = ("block_move_min_work_smooth",)  # as many meshes as degrees of smoothing
SECONDS = 90  # for one solve
NEAR = 1e-3  # of 1 + |J*|: a result this near to the optimum is one
WANTED_ALARMS, WANTED_MISSES = 0.02, 0
VERDICTS = "verdicts.jsonl"
"""In the folder: a line for each case that was judged."""

MAXIMUM = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: -1, upper: 1}, v: {}}
objective: {minimize: {integral: -u**2 + v**2 + u*v}}
mesh: [{method: gauss, segments: 4, degree: 2}]
"""
CIRCLE = RANGE.replace("{lower: -10, upper: 10}", "{}").replace("{constants: {a: 1, b: 0, v: 1}}", "GUESS")
LESSER = CIRCLE.replace("guess: GUESS\n", "mesh: [{method: radau, segments: 20}]\n")
MANY_TURNS = CIRCLE.replace("guess: GUESS\n", "mesh: [{method: hermite-simpson, segments: 25}]\n")
TWO_WELLS = """
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
controls: {u: {lower: -2, upper: 2}}
objective: {minimize: {integral: "(u**2 - 1)**2 + 0.2*u"}}
guess: {constants: {u: 1, x: 0.5}}
mesh: [{method: radau, segments: 5}]
"""
WRONG = {
    "a maximum in place of a minimum": (MAXIMUM, None),
    "the lesser of two optima": (LESSER, 1.712315),
    "an extremal of many turns": (MANY_TURNS, 1.712315),
    "the higher of two wells": (TWO_WELLS, None),
}
"""Name -> (problem, its optimum, or None if whatever is found is wrong)."""


@dataclass(frozen=True)
class Job:
    """One solve: of a text, or of a shipped problem with overrides; optimum: where it is known; bad: whatever is found,
    unless it is that optimum."""

    name: str
    text: str = ""
    overrides: tuple[str, ...] = ()
    optimum: float | None = None
    bad: bool = False
    tamper: bool = False

    @property
    def file(self) -> str:
        return "".join(c if c.isalnum() else "-" for c in self.name) + ".h5"


@dataclass
class Verdict:
    """Of one job: why there is none, or the checks that failed; tampered: kind -> the checks that saw it."""

    job: Job
    left_out: str = ""
    failed: list[str] = field(default_factory=list)
    tampered: dict[str, list[str]] = field(default_factory=dict)
    seconds: float = 0.0

    @property
    def told(self) -> str:
        """In one line: why there is none, what failed on a good result, and what a bad one was passed for."""
        if self.left_out:
            return f"{self.job.name}: left out, {self.left_out.splitlines()[0]}"
        own = "; ".join(self.failed) or "passed"
        missed = "".join(f"; MISSED: {kind}" for kind, checks in self.tampered.items() if not checks)
        wrong = bool(self.failed) != self.job.bad
        return f"{'WRONG  ' * wrong}{self.job.name}: {own}{missed} ({self.seconds:.1f} s)"


def jobs() -> list[Job]:
    found = [Job(f"{name} as shipped", overrides=(name,)) for name in sorted(shipped()) if name not in LEFT_OUT]
    known = {own.name: own for own in KNOWN if not own.build}
    names = [*(n for n in sorted(shipped()) if n not in (*LEFT_OUT, *ONLY_AS_SHIPPED, *known)), *known]
    for i, name in enumerate(names):
        own = known.get(name)
        for j, (method, segments) in enumerate(METHODS.items()):
            mesh = f"mesh=[{{method: {method}, segments: {segments}}}]"
            if name in SCHEDULED:
                mesh = f"mesh.*.method={method}"
            overrides = (*(own.overrides if own else ()), mesh, "refine={}")
            text, optimum = (own.text, own.optimum) if own else ("", None)
            overrides = overrides if text else (name, *overrides)
            found.append(Job(f"{name}, {method}", text, overrides, optimum, tamper=(i + j) % len(METHODS) == 0))
    for name, (text, optimum) in WRONG.items():
        found.append(Job(name, _headed(text, name), (), optimum, bad=True))
    return found


def _headed(text: str, name: str) -> str:
    return text if text.lstrip().startswith("trajopt:") else f"trajopt: 1\nname: {name}\n{text}"


def store(job: Job, path: Path) -> str:
    """Solve and write; why there is no good result, or ""."""
    if job.text:
        spec = load_text(job.text, f"{job.name}.yaml", [*job.overrides, f"solver.seconds={SECONDS}"])
    else:
        name, *rest = job.overrides
        spec = load(shipped()[name], [*rest, f"solver.seconds={SECONDS}"] if rest else [])
    problems = build_all(spec)
    # The problem's own start, told to be one, is not replaced by a better one.
    guess = [phase.guess for phase in problems[0].phases] if job.bad else None
    solution = solve_spec(spec, problems, guess=guess)  # through its continuation, if it has one
    if not solution.solved:
        return solution.status.name.lower()
    if solution.inaccurate and not job.bad and "as shipped" not in job.name:
        return "tolerance missed"
    if job.optimum is not None:
        apart = abs(solution.objective - job.optimum) / (1 + abs(job.optimum))
        if (apart <= NEAR) is job.bad:
            return f"objective {solution.objective:.7g}, optimum {job.optimum:.7g}"
    write(path, solution, spec.text, spec.model_dump_json(), "benchmark", spec.overrides)
    return ""


def failed(path: Path) -> list[str]:
    return [f"{c.name}: {c.value:.2g} > {c.limit:.2g} {c.where}" for c in verify(path) if not c.passed]


def run(job: Job, folder: Path) -> Verdict:
    path, why = folder / job.file, folder / f"{job.file}.txt"
    if not path.exists() and not why.exists():
        try:
            reason = store(job, path)
        except Exception as error:
            reason = f"{type(error).__name__}: {error}"
        if reason:
            why.write_text(reason)
    if why.exists():
        return Verdict(job, left_out=why.read_text())
    began = time.perf_counter()
    verdict = Verdict(job, failed=failed(path), seconds=time.perf_counter() - began)
    if job.tamper:
        for kind, change in tampering.KINDS.items():
            other = folder / f"tampered-{os.getpid()}.h5"
            if change(path, other):
                verdict.tampered[kind] = failed(other)
            other.unlink(missing_ok=True)
    return verdict


def judge(own: Sequence[Job], folder: Path, workers: int, resume: bool) -> list[Verdict]:
    """The verdicts of all jobs, told and kept in the folder as they come."""
    kept = folder / VERDICTS
    lines = kept.read_text().splitlines() if resume and kept.exists() else []
    known = {told["name"]: told for told in map(json.loads, lines)}
    verdicts = {job.name: Verdict(job, **known[job.name]["verdict"]) for job in own if job.name in known}
    waiting = [job for job in own if job.name not in verdicts]
    with ProcessPoolExecutor(workers) as pool, kept.open("a" if resume else "w") as file:
        for future in as_completed([pool.submit(run, job, folder) for job in waiting]):
            verdict = future.result()
            verdicts[verdict.job.name] = verdict
            told = {key: value for key, value in asdict(verdict).items() if key != "job"}
            print(json.dumps({"name": verdict.job.name, "verdict": told}), file=file, flush=True)
            print(f"{len(verdicts):4d}/{len(own)}  {verdict.told}", flush=True)
    return [verdicts[job.name] for job in own]


def report(verdicts: list[Verdict]) -> bool:
    """Print the tables; whether the rates are as wanted."""
    good = [v for v in verdicts if not v.job.bad and not v.left_out]
    alarms = [v for v in good if v.failed]
    print("| good result | checks that fail |\n| --- | --- |")
    for v in alarms:
        print(f"| {v.job.name} | {'; '.join(v.failed)} |")
    print("\n| bad result | cases | missed | seen by |\n| --- | --- | --- | --- |")
    kinds = {kind: [(v, v.tampered[kind]) for v in good if kind in v.tampered] for kind in tampering.KINDS}
    kinds |= {v.job.name: [(v, v.failed)] for v in verdicts if v.job.bad and not v.left_out}
    missed = []
    for kind, cases in kinds.items():
        seen = Counter(f.split(":")[0] for _, checks in cases for f in checks).most_common(3)
        own = [f"{kind}: {v.job.name}" for v, checks in cases if not checks]
        missed += own
        print(f"| {kind} | {len(cases)} | {len(own)} | {'; '.join(name for name, _ in seen)} |")
    bad = sum(map(len, kinds.values()))
    print("\nleft out:", "; ".join(f"{v.job.name} ({v.left_out})" for v in verdicts if v.left_out) or "none")
    print("missed:", "; ".join(missed) or "none")
    rate = len(alarms) / max(len(good), 1)
    met = rate <= WANTED_ALARMS and len(missed) <= WANTED_MISSES
    wanted = f"wanted: at most {100 * WANTED_ALARMS:.0f} %"
    print(f"\nfalse alarms: {len(alarms)} of {len(good)}, {100 * rate:.1f} % ({wanted})")
    print(f"misses: {len(missed)} of {bad} (wanted: {WANTED_MISSES}); {'met' if met else 'not met'}")
    return met


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--folder", type=Path)
    parser.add_argument("--only", default="")
    parser.add_argument("--workers", type=int, default=2)
    parser.add_argument("--resume", action="store_true")
    arguments = parser.parse_args()
    if arguments.resume and not arguments.folder:
        parser.error("--resume needs the --folder of the run before")
    own = [job for job in jobs() if arguments.only in job.name]
    own.sort(key=lambda job: crc32(job.name.encode()))
    with tempfile.TemporaryDirectory() as scratch:
        folder = arguments.folder or Path(scratch)
        folder.mkdir(parents=True, exist_ok=True)
        met = report(judge(own, folder, arguments.workers, arguments.resume))
    sys.exit(0 if met else 1)


if __name__ == "__main__":
    main()
