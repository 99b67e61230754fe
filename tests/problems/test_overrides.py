"""An override does what the same line in the file does: the mesh and its refinement, sizes, the engine."""

import pytest
from command_line import trajopt

from trajopt.cli.errors import TOLERANCE_MISSED
from trajopt.problems.errors import SpecError
from trajopt.problems.load import load_text
from trajopt.transcription.schemes.table import METHODS

PLAIN = """trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0}}
controls: {u: {}}
objective: {minimize: {integral: u**2}}
"""
WRITTEN = PLAIN + "mesh: [{method: trapezoid, segments: 20}]\n"


def loaded(text, *overrides):
    return load_text(text, "plain.yaml", overrides, tuple(METHODS))


@pytest.mark.parametrize("text", [PLAIN, WRITTEN])
@pytest.mark.parametrize(
    "line",
    [
        "mesh: [{method: trapezoid, segments: 10}]", "mesh:", "refine:", "refine: {}", "refine: {tolerance: 1e-4}",
        "refine: {max_meshes: 3}", "scaling: {v: 3}", "solver: {engine: newton}",
    ],
)  # fmt: skip
def test_an_override_is_the_line_in_the_file(text, line):
    key, _, value = line.partition(": ") if ": " in line else (line[:-1], "", "")
    rest = "".join(old for old in text.splitlines(keepends=True) if not old.startswith(f"{key}:"))
    assert loaded(text, f"{key}={value}").model_dump() == loaded(f"{rest}{line}\n").model_dump()


@pytest.mark.parametrize(
    ("overrides", "method", "segments", "refined"),
    [
        ([], "radau", 10, True),
        (["mesh.0.segments=50"], "radau", 50, True),
        (["mesh.*.method=trapezoid", "mesh.-1.segments=7"], "trapezoid", 7, True),
        (["mesh=[{method: trapezoid, segments: 10}]"], "trapezoid", 10, False),
        (["mesh=[{method: trapezoid, segments: 10}]", "mesh.0.segments=50"], "trapezoid", 50, False),
        (["mesh.0.segments=50", "mesh=[{method: trapezoid, segments: 10}]"], "trapezoid", 10, False),
        (["mesh=[{method: trapezoid, segments: 10}]", "refine.tolerance=1e-3"], "trapezoid", 10, True),
    ],
)
def test_a_file_without_a_mesh(overrides, method, segments, refined):
    """Overrides of a part refer to the mesh that is chosen, and it is refined; one of the whole is another mesh."""
    spec = loaded(PLAIN, *overrides)
    (mesh,) = spec.mesh
    assert (mesh.method, mesh.segments, spec.refine is not None) == (method, segments, refined)


def test_sizes_of_velocities_and_slack_variables():
    text = PLAIN.replace("rate: v, ", "accel: u, velocity: {name: w}, ").replace("v: {rate: u", "v: {rate: x")
    text = text.replace("u**2", "abs(u)") + "nonsmooth: slack\n"
    assert loaded(text, "scaling={w: 2, abs1_plus: 3}").scaling == {"w": 2, "abs1_plus": 3}
    with pytest.raises(SpecError, match=r"--set scaling.abs2_plus: abs2_plus is no state.* did you mean abs1_plus"):
        loaded(text, "scaling.abs2_plus=3")


@pytest.mark.parametrize("method", sorted(METHODS.keys() - {"finite-difference"}))
def test_newton_takes_what_the_check_lets_pass(method, folder):
    (folder / "plain.yaml").write_text(PLAIN)
    changes = ["--set", "solver.engine=newton", "--set", "time.final={lower: 1, upper: 1}", "--method", method]
    run = trajopt("solve", "plain.yaml", *changes, "--refine", "0.5", "-q")
    assert run.exit_code in (0, TOLERANCE_MISSED) and not run.stderr


def test_all_that_newton_cannot_do_is_told_at_once(folder):
    (folder / "bounded.yaml").write_text(
        PLAIN.replace("u: {}", "u: {upper: 9}").replace("v: {rate: u, initial: 0,", "v: {rate: u, initial: {lower: 0},")
        + "constraints:\n  path:\n    - {expression: v, upper: 3}\nsolver: {engine: newton}\n"
    )
    run = trajopt("check", "bounded.yaml")
    told = [line.removeprefix("error: bounded.yaml:").split(": the Newton")[0] for line in run.stderr.splitlines()]
    assert run.exit_code == 2
    assert told == ["3: states.v.initial.lower", "4: controls.u.upper", "8: constraints.path.0"]


def test_what_a_method_cannot_do_is_told_by_check_at_its_mesh(folder):
    meshes = ("{method: radau, segments: 5}", "{method: finite-difference, segments: 1}")
    (folder / "plain.yaml").write_text(PLAIN + "mesh:\n" + "".join(f"  - {mesh}\n" for mesh in meshes))
    run = trajopt("check", "plain.yaml")
    assert run.exit_code == 2
    needs, equal = run.stderr.splitlines()
    assert needs.startswith("error: plain.yaml:8: mesh.1: finite-difference needs second-order dynamics")
    assert equal.startswith("error: plain.yaml:8: mesh.1: finite-difference needs two or more equal segments")


def test_no_file_is_solved_before_all_are_checked(folder):
    (folder / "good.yaml").write_text(PLAIN)
    for name in ("a.yaml", "b.yaml"):
        (folder / name).write_text(PLAIN + "mesh:\n  - {method: finite-difference, segments: 5}\n")
    for command in ("check", "solve"):
        run = trajopt(command, "good.yaml", "a.yaml", "b.yaml")
        assert run.exit_code == 2 and not run.stdout
        assert [line.split(": ")[1] for line in run.stderr.splitlines()] == ["a.yaml:7", "b.yaml:7"]
    assert not list(folder.glob("*.h5"))


def test_what_only_the_solution_finds_names_the_file(folder):
    (folder / "plain.yaml").write_text(PLAIN)
    run = trajopt("solve", "plain.yaml", "--method", "finite-difference")
    assert run.exit_code == 2
    assert run.stderr.startswith("error: --method: finite-difference needs second-order dynamics, and 'x' has none")
    (folder / "plain.yaml").write_text(PLAIN + "mesh:\n  - {method: finite-difference, segments: 5}\n")
    run = trajopt("solve", "plain.yaml")
    assert run.exit_code == 2
    assert run.stderr.startswith("error: plain.yaml:7: mesh.0: finite-difference needs")


@pytest.mark.parametrize(("section", "value"), [("parameters", "5"), ("controls", "seven"), ("states", "[x, v]")])
def test_an_override_within_a_section_that_is_none(section, value):
    text = f"trajopt: 1\ntime: {{initial: 0, final: 1}}\n{section}: {value}\nobjective: {{minimize: {{terminal: 1}}}}\n"
    with pytest.raises(SpecError, match=f"{section} has no m"):
        load_text(text, "x.yaml", [f"{section}.m.unit=kg"])
