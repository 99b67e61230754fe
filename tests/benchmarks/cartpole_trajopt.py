"""Cart-pole with trajopt, from problems/cartpole.yaml to the solution.

Run as `python cartpole_trajopt.py SEGMENTS`; prints one JSON object.

The file is read and checked inside "build", since the other tools have no file to read. The error estimate is left out
of "total", since the other tools make none.
"""

import json
import resource
import sys
import time

began = time.perf_counter()

from trajopt.problems.build import build  # noqa: E402
from trajopt.problems.catalog import find  # noqa: E402
from trajopt.problems.load import load  # noqa: E402
from trajopt.transcription.ipopt import check_options  # noqa: E402
from trajopt.transcription.solve import solve, steps  # noqa: E402

check_options({})  # imports cyipopt, which is otherwise imported by the first solve
imported = time.perf_counter()


def main(segments):
    start, cpu = time.perf_counter(), time.process_time()
    spec = load(find("cartpole"), [f"mesh.-1.segments={segments}"])
    problem, schedule = build(spec), steps(spec.mesh)
    read = time.perf_counter() - start
    solution = solve(problem, schedule)
    whole, cpu = time.perf_counter() - start, time.process_time() - cpu
    (mesh,) = solution.meshes
    seconds = {
        "import": imported - began,
        "build": read + mesh.seconds["build"],
        "compile": sum(mesh.seconds[part] for part in ("differentiate", "compile", "assemble")),
        "solve": mesh.seconds["evaluate"] + mesh.seconds["linear algebra"],
        "evaluate": mesh.seconds["evaluate"],
        "total": whole - mesh.seconds["error"],
        "CPU": cpu - mesh.seconds["error"],
    }
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024
    outcome = {"iterations": mesh.iterations, "objective": solution.objective, "solved": solution.solved}
    print(json.dumps({**seconds, "memory": memory, **outcome}))


if __name__ == "__main__":
    main(int(sys.argv[1]))
