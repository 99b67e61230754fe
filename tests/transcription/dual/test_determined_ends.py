"""Path constraints and bounds of what the states determine hold at both ends of time, by every method, and no
multiplier of theirs there is taken for a density."""

import pytest
from command_line import trajopt

from trajopt.problems.build import build
from trajopt.problems.conserved.determined import determined, of_states_alone
from trajopt.problems.load import load_text
from trajopt.transcription.settings import Settings, steps
from trajopt.transcription.solve import solve

FROM_START = """\
trajopt: 1
time: {initial: 0, final: 1}
states: {x: {rate: u, initial: 0}}
algebraic: {z: {BOUND}}
residuals: [RESIDUAL]
controls: {u: {lower: -10, upper: 10}}
objective: {maximize: {terminal: "x[final]", integral: -0.01*u**2}}
PATH
mesh: [{method: METHOD, segments: 6}]
"""
TO_END = (
    FROM_START.replace("initial: 0}}\\n", "")
    .replace("rate: u, initial: 0", "rate: -u, final: 0")
    .replace("x[final]", "x[initial]")
)
CAP = "constraints: {path: [{name: cap, expression: z, upper: 4}]}"

CASES = {  # x reaches 2 at a constant u = 2, so J = 2 - 0.04
    "a square": ("z - x**2", "", CAP),
    "an implicit one": ("z**3 + z - 34*x", "", CAP),
    "its bound": ("z - x**2", "upper: 4", ""),
    "through another": ("[w - 3*x - t*0, z - w*w/9]", "", CAP),
}
METHODS = ["radau", "radau-left", "gauss", "lobatto", "midpoint", "implicit-euler", "explicit-euler", "hermite-simpson"]


def text(template: str, case: str, method: str) -> str:
    residual, bound, path = CASES[case]
    filled = template.replace("[RESIDUAL]", residual if residual.startswith("[") else f"[{residual}]")
    filled = filled.replace("z: {BOUND}", f"z: {{{bound}}}" + (", w: {}" if "w" in residual else ""))
    return filled.replace("PATH", path).replace("METHOD", method)


def solved(text: str):
    spec = load_text(text, "x.yaml")
    return solve(build(spec), steps(spec.mesh), Settings())


@pytest.mark.parametrize("template", [FROM_START, TO_END], ids=["final", "initial"])
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("case", CASES)
def test_it_holds_at_a_free_end(case, method, template):
    solution = solved(text(template, case, method))
    assert solution.solved
    assert solution.objective == pytest.approx(1.96, abs=1e-6)
    assert abs(solution.objective - 1.96) <= solution.objective_error.bar <= 1e-4


@pytest.mark.parametrize(("case", "method", "template"), [
    ("a square", "radau", FROM_START), ("an implicit one", "gauss", TO_END), ("its bound", "lobatto", FROM_START),
    ("through another", "radau-left", TO_END),
])  # fmt: skip
def test_verify_passes(case, method, template, tmp_path, monkeypatch):
    """What acts at one end only was a failure of dH/du there."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "x.yaml").write_text(text(template, case, method))
    assert trajopt("solve", "x.yaml").exit_code == 0
    checked = trajopt("verify", "x.h5")
    assert checked.exit_code == 0, checked.stdout


def phase_of(residuals: str, algebraic: str):
    head = FROM_START.replace("[RESIDUAL]", residuals).replace("z: {BOUND}", algebraic).replace("PATH", "")
    (phase,) = build(load_text(head.replace("METHOD", "radau"), "x.yaml")).phases
    return phase


@pytest.mark.parametrize(
    ("residuals", "algebraic", "names"),
    [
        ("[z - x**2]", "z: {}", {"z"}),
        ("[z - x**2, w - z*u]", "z: {}, w: {}", {"z"}),  # w is of the control, too
        ("[z - u]", "z: {}", set()),
        ("[z - x, w - z - t]", "z: {}, w: {}", {"z", "w"}),
        ("[z + w - x, w - u]", "z: {}, w: {}", set()),
    ],
)
def test_what_the_states_determine(residuals, algebraic, names):
    phase = phase_of(residuals, algebraic)
    assert determined(phase).names == names
    for variable in phase.algebraic:
        function = lambda values, functions, name=variable.name: values[name] + values["x"]  # noqa: E731
        assert of_states_alone(phase, function) == (variable.name in names)
