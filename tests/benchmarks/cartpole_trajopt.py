"""Cart-pole with trajopt, from problems/cartpole.yaml to the solution.

Run as `python cartpole_trajopt.py SEGMENTS [OVERRIDE...]`, overrides as for `trajopt solve --set`; prints one JSON
object. Seconds and iterations are those of all meshes, a coarse one to start from too.

The file is read and checked inside "build", since the other tools have no file to read. The error estimate is left out
of "total", since the other tools make none.
"""

import json
import resource
import sys
import time

began = time.perf_counter()

from trajopt.problems.build import build  # noqa: E402
from trajopt.problems.catalog import find_problem  # noqa: E402
from trajopt.problems.load import load  # noqa: E402
from trajopt.transcription.engines.ipopt import check_options  # noqa: E402
from trajopt.transcription.settings import settings_of, steps  # noqa: E402
from trajopt.transcription.solve import solve  # noqa: E402

check_options({})  # imports cyipopt, which is otherwise imported by the first solve
imported = time.perf_counter()


def main(segments, overrides):
    start, cpu = time.perf_counter(), time.process_time()
    spec = load(find_problem("cartpole"), [f"mesh.-1.segments={segments}", *overrides])
    problem, schedule = build(spec), steps(spec.mesh)
    read = time.perf_counter() - start
    solution = solve(problem, schedule, settings_of(spec))
    whole, cpu = time.perf_counter() - start, time.process_time() - cpu
    spent = {part: sum(mesh.seconds[part] for mesh in solution.meshes) for part in solution.meshes[0].seconds}
    seconds = {
        "import": imported - began,
        "build": read + spent["build"],
        "compile": spent["differentiate"] + spent["compile"] + spent["assemble"],
        "solve": spent["evaluate"] + spent["linear algebra"],
        "evaluate": spent["evaluate"],
        "total": whole - spent["error"],
        "CPU": cpu - spent["error"],
    }
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    iterations = sum(mesh.iterations for mesh in solution.meshes)
    outcome = {"iterations": iterations, "objective": solution.objective, "solved": solution.solved}
    print(json.dumps({**seconds, "memory": memory, **outcome}))


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
