"""Problems of several phases: from the file to the optimum, for every kind of method; links, order, guesses."""

import gc
import weakref

import numpy as np
import pytest

from trajopt.problems.build import build
from trajopt.problems.errors import SpecError
from trajopt.problems.phases.merge import home, phase_specs
from trajopt.problems.phases.order import Passage, passages
from trajopt.transcription.layout import bounded_start
from trajopt.transcription.loading import build_checked, load_file, load_yaml
from trajopt.transcription.scaling import scale
from trajopt.transcription.settings import Refine, Settings, Step, schedule_of
from trajopt.transcription.solve import solve
from trajopt.transcription.transcribe import compiled, transcribe

from .phased import CURVE, MOVE, loaded, solved


@pytest.mark.parametrize(
    ("methods", "digits"),
    [
        (("hermite-simpson", "hermite-simpson"), 1e-9), (("radau", "gauss"), 1e-9), (("trapezoid", "radau"), 0.1),
        (("runge-kutta-4", "runge-kutta-4"), 1e-8), (("runge-kutta-4", "radau"), 1e-8),
        (("hermite-simpson-compressed", "dormand-prince"), 1e-8), (("lobatto", "midpoint"), 0.2),
    ],
)  # fmt: skip
def test_two_phases_by_any_two_methods_have_the_optimum_of_one(methods, digits):
    own = [
        f"phases.{name}.mesh=[{{method: {m}, segments: 6}}]"
        for name, m in zip(("first", "second"), methods, strict=True)
    ]
    solution = solved(MOVE, *own)
    assert solution.objective == pytest.approx(CURVE, abs=digits)
    first, second = solution.trajectories
    assert first.t[1] == pytest.approx(second.t[0], abs=1e-12) and 0.2 < first.t[1] < 0.8
    assert first.x[:, -1] == pytest.approx(second.x[:, 0], abs=1e-9)
    bar = solution.objective_error
    assert bar.applies and abs(solution.objective - CURVE) <= bar.bar


def test_costates_go_on_where_states_do():
    first, second = solved(MOVE).trajectories
    assert first.costate[:, -1] == pytest.approx(second.costate[:, 0], rel=1e-6)


@pytest.mark.parametrize("kind", ["hermite-simpson", "runge-kutta-4"])
def test_derivatives_of_links_and_of_the_whole_objective(kind):
    """Nonlinear links of two phases and a parameter, against central differences."""
    text = MOVE.replace("objective: {minimize: {integral: u**2}}", """
optimize: {p: {lower: 0.5, upper: 2}}
links:
  - {from: first, to: second, except: [v]}
  - {expression: "p*sin(second.v[initial]) - first.v[final]**2*second.t[final]", equals: 0.1}
objective: {minimize: {integral: u**2, terminal: "(first.x[final] - p)**2*second.t[initial] + exp(v[initial])"}}
""")  # fmt: skip
    problem = build(loaded(text))
    mesh = Step(kind, 2, 1e-8).mesh()
    transcription = transcribe(problem, [mesh, mesh])
    nlp = compiled(transcription)
    rng = np.random.default_rng(3)
    z, y = bounded_start(transcription)[0] + rng.uniform(0.1, 0.4, nlp.n), rng.normal(size=nlp.m)
    jacobian, hessian = np.zeros((nlp.m, nlp.n)), np.zeros((nlp.n, nlp.n))
    np.add.at(jacobian, nlp.jacobianstructure(), nlp.jacobian(z))
    np.add.at(hessian, nlp.hessianstructure(), nlp.hessian(z, y, 0.7))
    hessian = np.tril(hessian) + np.tril(hessian, -1).T
    step = 1e-6

    def lagrangian(at):
        own = np.zeros((nlp.m, nlp.n))
        np.add.at(own, nlp.jacobianstructure(), nlp.jacobian(at))
        return 0.7 * nlp.gradient(at) + y @ own

    for k in range(nlp.n):
        up, down = (z + side * step * (np.arange(nlp.n) == k) for side in (1, -1))
        slope = (nlp.constraints(up) - nlp.constraints(down)) / (2 * step)
        assert jacobian[:, k] == pytest.approx(slope, abs=1e-7)
        assert nlp.gradient(z)[k] == pytest.approx((nlp.objective(up) - nlp.objective(down)) / (2 * step), abs=1e-6)
        assert hessian[:, k] == pytest.approx((lagrangian(up) - lagrangian(down)) / (2 * step), abs=1e-6)


def test_the_top_level_is_every_phase_s_default_but_for_the_ends():
    spec = loaded(MOVE, "phases.second.states.v={upper: 3}", "phases.first.controls.u={lower: -9}")
    first, second = phase_specs(spec).values()
    assert first.states["x"].initial.value.text == "0" and first.states["x"].final is None
    assert second.states["x"].initial is None and second.states["x"].final.value.text == "1"
    assert (
        second.states["v"].upper.text == "3" and second.states["v"].rate.text == "u" and first.states["v"].upper is None
    )
    assert first.controls["u"].unit == "m/s^2" and first.controls["u"].lower.text == "-9"
    assert home(spec, "second", ("states", "v", "upper")) == ("phases", "second", "states", "v", "upper")
    assert home(spec, "second", ("states", "v", "rate")) == ("states", "v", "rate")


def test_parameters_constraints_and_integrals_of_one_phase():
    text = MOVE.replace("rate: u,", "rate: k*u,").replace("phases:", "parameters: {k: 1}\nphases:")
    problem = build(
        loaded(
            text,
            "phases.second.parameters.k=2",
            "constraints={path: [{expression: u, upper: 50}]}",
            "phases.first.constraints={path: [{expression: v, upper: 3}], integral: [{expression: u, lower: 0}]}",
            "phases.first.objective={minimize: {integral: 3*u**2}}",
        )
    )
    first, second = problem.phases
    values = {"t": 0.0, "x": 0.0, "v": 1.0, "u": 5.0}
    assert [p.states[1].rate(values, np) for p in problem.phases] == [5.0, 10.0]
    assert [len(p.path) for p in problem.phases] == [2, 1]
    assert [len(p.integral) for p in problem.phases] == [1, 0]
    assert [p.lagrange(values, np) for p in (first, second)] == [75.0, 25.0]


def test_a_phase_may_lack_a_state_and_have_one_of_its_own():
    text = MOVE.replace("first: {}", "first: {states: {w: {rate: u, initial: 2}}}")
    first, second = solved(text).trajectories
    assert [s.name for s in first.phase.states] == ["x", "v", "w"] and [s.name for s in second.phase.states] == [
        "x",
        "v",
    ]
    assert first.x[2, -1] == pytest.approx(2 + first.x[1, -1])
    problem = build(loaded(MOVE, "phases.second.without=[v]", "phases.second.states.x.rate=u"))
    assert [s.name for s in problem.phases[1].states] == ["x"]
    assert [link.name for link in problem.links] == ["t from first to second", "x from first to second"]


def test_links_in_place_of_the_default_ones():
    three = MOVE.replace("first: {}", "first: {}\n  middle: {}")
    assert passages(loaded(three)) == [
        Passage("first", "middle", frozenset()), Passage("middle", "second", frozenset())
    ]  # fmt: skip
    branches = loaded(three, "links=[{from: first, to: second, except: [v]}]")
    assert passages(branches) == [
        Passage("first", "middle", frozenset()), Passage("first", "second", frozenset({"v"}), 0)
    ]  # fmt: skip
    names = [link.name for link in build(branches).links]
    assert names == [
        "t from first to middle", "x from first to middle", "v from first to middle",
        "t from first to second", "x from first to second",
    ]  # fmt: skip


def test_a_circle_makes_a_periodic_motion():
    """The least mean force that keeps a pendulum swinging through half a turn: none is needed, at its own period."""
    text = """
trajopt: 1
time: {initial: 0, final: {lower: 4, upper: 9, guess: 6}}
states: {q: {rate: w, initial: 0.5}, w: {rate: u - q}}
controls: {u: {}}
phases: {swing: {}}
links: [{from: swing, to: swing}]
objective: {minimize: {integral: u**2}}
"""
    solution = solved(text)
    assert solution.objective == pytest.approx(0, abs=1e-9)
    assert solution.trajectories[0].t[1] == pytest.approx(2 * np.pi, abs=1e-3)


def test_waypoints_are_phases():
    base = MOVE[: MOVE.index("phases:")] + MOVE[MOVE.index("objective:") :]
    spec = loaded(base, "waypoints=[{time: 0.25, x: 0.5}, {name: late, x: 0.9}]")
    assert list(phase_specs(spec)) == ["leg1", "late", "leg3"]
    solution = solved(base, "waypoints=[{time: 0.25, x: 0.5}, {name: late, x: 0.9}]")
    ends = [(t.t[1], t.x[0, -1]) for t in solution.trajectories]
    assert (
        ends[0] == pytest.approx((0.25, 0.5)) and ends[1][1] == pytest.approx(0.9) and ends[2] == pytest.approx((1, 1))
    )
    through = solved(base, "waypoints=[{x: 0.5}]")
    assert through.objective == pytest.approx(CURVE, abs=1e-8)  # the waypoint is on the way
    assert through.trajectories[0].t[1] == pytest.approx(0.5, abs=1e-6)


def test_a_phase_may_be_as_short_as_nothing():
    """Two branches of control, of which the optimum needs the cheaper one only."""
    text = MOVE.replace("first: {}", "first: {objective: {minimize: {integral: 9*u**2 + 1}}}").replace(
        "second: {time: {initial: {lower: 0.2, upper: 0.8}}}", "second: {}"
    )
    solution = solved(text)
    assert solution.trajectories[0].t[1] == pytest.approx(0, abs=1e-6)
    assert solution.objective == pytest.approx(CURVE, abs=1e-5)


def test_the_guess_goes_through_the_phases():
    problem = build(loaded(MOVE, "time.final=4", "phases.first.time={final: 1}", "phases.second.time="))
    first, second = problem.phases
    assert first.guess.values["x"].tolist() == [0, 0.25] and second.guess.values["x"].tolist() == [0.25, 1]
    framed = build(
        loaded(MOVE, "time.final=4", "phases.first.time={final: 1}", "phases.second.time=",
               "guess={keyframes: {time: [0, 2, 4], x: [0, 6, 1], u: [1, 3, 5]}, constants: {v: 7}}")
    )  # fmt: skip
    one, two = (phase.guess.samples(np.array([0.0, 1 / 3, 1.0])) for phase in framed.phases)
    assert one["x"] == pytest.approx([0, 1, 3]) and two["x"] == pytest.approx([3, 6, 1])
    assert one["u"] == pytest.approx([1, 4 / 3, 2]) and two["u"] == pytest.approx([2, 3, 5])
    assert one["v"].tolist() == [7, 7, 7]
    own = build(loaded(MOVE, "phases.second.guess={constants: {x: 0.3}}")).phases
    assert own[1].guess.values["x"].tolist() == [0.3, 0.3] and own[0].guess.values["x"].tolist() == [0, 0.3]


def test_each_phase_has_its_own_schedule_and_is_refined_by_itself():
    text = MOVE.replace("u**2}}", "u**2 + exp(-30*t)*x*v}}")
    meshes = ["phases.first.mesh=[{method: trapezoid, segments: 4}, {method: trapezoid, segments: 8}]"]
    solution = solved(text, *meshes, settings=Settings(refine=Refine(1e-6)))
    assert [m.grids[0].segments for m in solution.meshes[:2]] == [4, 8]
    assert [m.grids[1].segments for m in solution.meshes[:2]] == [6, 6]
    assert not solution.unmet and solution.meshes[-1].grids[0].segments > 8
    assert solution.meshes[-1].segments == sum(mesh.segments for mesh in solution.meshes[-1].grids)


def test_sizes_of_the_scaling_are_of_each_phase():
    spec = loaded(MOVE, "phases.first.states.v={lower: -50, upper: 50}", "phases.second.states.v={lower: -2, upper: 2}")
    transcription = transcribe(build(spec), [step.mesh() for step in schedule_of(spec)[0]])
    nlp = compiled(transcription)
    sizes = scale(transcription, nlp, bounded_start(transcription)[0], {"x": 3.0}).sizes
    assert (sizes["first.v"], sizes["second.v"], sizes["first.x"], sizes["second.x"]) == (50, 2, 3, 3)


def test_a_link_that_cannot_hold_is_named():
    text = MOVE.replace(
        "objective:", 'links: [{name: jump, expression: "second.v[initial] + x[final]", equals: 99}]\n\nobjective:'
    )
    text = text.replace("unit: m/s,", "unit: m/s, lower: -2, upper: 2,")
    spec = loaded(text)
    solution = solve(build(spec), schedule_of(spec))
    assert not solution.solved
    assert any("link 'jump'" in str(v) and "phase" not in str(v) for v in solution.violations)
    assert any("link 'jump'" in way for way in solution.relief)


def test_what_only_the_methods_know_is_told_of_the_phase():
    wrong = "phases.second.mesh=[{method: radau, segments: 3}, {method: trapezoid, segments: 4, degree: 3}]"
    differences = "phases.first.mesh=[{method: finite-difference, segments: 4}]"
    with pytest.raises(SpecError) as error:
        load_yaml(MOVE, [wrong])
    assert [m.where for m in error.value.mistakes] == ["--set phases.second.mesh"]
    with pytest.raises(SpecError, match="needs second-order dynamics") as error:
        build_checked([load_yaml(MOVE, [differences])])
    assert [m.where for m in error.value.mistakes] == ["--set phases.first.mesh"]


def test_tables_in_dynamics_and_links_of_phases():
    """A link that a table scales, by points of a straight line: the same as the formula."""
    table = "tables={f: {points: {x: [0, 0.3, 0.6, 1]}, values: [1, 1.3, 1.6, 2], outside: extrapolate}}"
    jump = "{expression: '%s*second.v[initial] - first.v[final]', equals: 0}"
    links = f"links=[{{from: first, to: second, except: [v]}}, {jump}]"
    given = table, "phases.second.time.initial=0.5"
    looked_up = solved(MOVE, *given, links % "f(second.x[initial])", "states.v.rate=u*f(x)")
    written = solved(MOVE, *given, links % "(1 + second.x[initial])", "states.v.rate=u*(1 + x)")
    assert looked_up.objective == pytest.approx(written.objective, rel=1e-8)
    with pytest.raises(SpecError, match="argument"):
        loaded(MOVE, *given, links % "f(second.x[initial], 2)")


@pytest.mark.parametrize("text", [MOVE, "cartpole"])
def test_a_problem_that_nobody_holds_is_gone(text):
    """The phases of the spec that was asked for last are kept, but not the spec."""
    spec = load_file(text) if text == "cartpole" else load_yaml(text)
    build_checked([spec])
    held = weakref.ref(spec)
    del spec
    gc.collect()
    assert held() is None


DOSED = """\
trajopt: 1
name: a vessel into which something is poured
parameters: {dose: 2, e: 0.5}
time: {initial: 0, final: 4}
states:
  V: {rate: F, initial: 1}
  w: {rate: -1 + F, initial: 3}
controls: {F: {lower: 0, upper: 1}}
phases: {before: {time: {final: 1}, states: {w: {final: 1}}}, after: {}}
links:
  - {from: before, to: after, except: [V, w]}
  - {expression: "after.V[initial] - before.V[final]", equals: dose}
  - "after.w[initial] == -e*before.w[final]"
objective: {minimize: {integral: F**2}}
"""


@pytest.mark.parametrize(
    ("old", "new", "wanted"),
    [
        ("", "", {"V": (3, 3), "w": (-0.5, -0.5)}),
        ("w: {rate: -1 + F, initial: 3}", "w: {rate: -1 + F, initial: 3, final: 2}", {"w": (-0.5, 2)}),
        ("equals: dose", "lower: dose, upper: 2*dose", {"V": (4, 4)}),
        ("equals: dose", "lower: dose", {"V": (0, 0)}),
        ("== -e*before.w[final]", "== before.w[final]**2 + before.V[final]", {"w": (2, 2)}),
        ("after: {}}", "after: {states: {V: {initial: {lower: 0, upper: 9}, final: 5}}}}", {"V": (3, 5)}),
        ("after: {}}", "after: {guess: {constants: {V: 7}}}}", {"V": (7, 7)}),
    ],
)
def test_the_guess_of_a_state_that_jumps_begins_where_the_link_puts_it(old, new, wanted):
    assert old in DOSED
    guess = build(load_yaml(DOSED.replace(old, new))).phases[1].guess
    assert {name: (guess.values[name][0], guess.values[name][-1]) for name in wanted} == wanted


def test_a_volume_that_a_dose_fills_is_divided_by():
    """Its guess was 0, at which S/V has no value: not solved."""
    text = DOSED.replace("w: {rate: -1 + F,", "w: {rate: -w/V + F,").replace(
        "{final: 1}}}, after", "{final: 1.5}}}, after"
    )
    spec = load_yaml(text)
    solution = solve(build(spec), schedule_of(spec))
    assert solution.solved and solution.trajectories[1].x[0, 0] == pytest.approx(solution.trajectories[0].x[0, -1] + 2)
