"""The arcs of solved problems: which, and when they switch; in words, in JSON, in the result file."""

from functools import cache

import numpy as np
import pytest
from command_line import trajopt
from named import ALL

from trajopt.cli.output.arcs import few_arcs
from trajopt.problems.quantities import Range
from trajopt.results.file.summary import summarize
from trajopt.results.file.write import write
from trajopt.transcription.arcs import CONTROL, INSIDE, LOWER, PATH, SINGULAR, STATE, UPPER, Arc, Course
from trajopt.transcription.continuation import solve_spec
from trajopt.transcription.loading import build_checked, load_file, load_yaml
from trajopt.transcription.schemes.mesh import Mesh
from trajopt.transcription.schemes.table import find
from trajopt.transcription.structure.courses import _share
from trajopt.transcription.structure.runs import arcs_of, snapped, with_touches

from .harvest import STOCK

MOVE = """\
trajopt: 1
name: rest to rest, bounded
time: {initial: 0, final: FINAL}
states: {x: {rate: v, initial: 0, final: 1}, v: {rate: u, initial: 0, final: 0BOUNDS}}
controls: {u: {lower: LOWER, upper: UPPER}}
objective: {minimize: OBJECTIVE}
"""
FREE = "{lower: 0.1, upper: 20, guess: 3}"


def move(lower=-1, upper=1, bounds="", final=FREE, objective='{terminal: "t[final]"}'):
    given = {"LOWER": lower, "UPPER": upper, "BOUNDS": bounds, "FINAL": final, "OBJECTIVE": objective}
    text = MOVE
    for word, value in given.items():
        text = text.replace(word, str(value))
    return text


BANGS = move(upper=2)  # max until 1/sqrt(3), then min until sqrt(3)
SPEED = move(bounds=", upper: 0.5")  # max until 1/2, v at its bound until 2
EFFORT = move(final=1, lower=-4.5, upper=9, objective='{integral: "u**2"}')  # 6 - 12 t without bounds
SMOOTH = move(final=1, lower=-50, upper=50, objective='{integral: "u**2"}')
UNBOUNDED = SMOOTH.replace("{lower: -50, upper: 50}", "{}")
DECAY = """\
trajopt: 1
name: a regulator with a control that only decays to its bound
time: {initial: 0, final: 8}
states: {x: {rate: u - 2, initial: 0, final: 1}}
controls: {u: {lower: 2}}
objective: {minimize: {integral: "(u - 2)**2*exp(t)"}}
"""


@cache
def solved(name):
    spec = load_yaml(name) if "\n" in name else load_file(name)
    (problems,) = build_checked([spec])
    return solve_spec(spec, problems), spec


def arcs(name, phase=0):
    """Name -> the arcs, as (on or by, end) each."""
    solution, _ = solved(name)
    assert solution.solved
    return {own.name: [(arc.by or arc.on, arc.end) for arc in own.arcs] for own in solution.arcs[phase]}


@pytest.mark.parametrize(
    ("name", "expected", "within"),
    [
        ("double_integrator_min_time", {"u": [(UPPER, 1), (LOWER, 2)]}, 1e-6),
        (BANGS, {"u": [(UPPER, 3**-0.5), (LOWER, 3**0.5)]}, 1e-5),
        (SPEED, {"u": [(UPPER, 0.5), ("held by v", 2), (LOWER, 2.5)],
                 "v": [(INSIDE, 0.5), (UPPER, 2), (INSIDE, 2.5)]}, 1e-3),
        (EFFORT, {"u": [(INSIDE, 5 / 6), (LOWER, 1)]}, 1e-4),
        (STOCK, {"h": [(LOWER, np.log(4)), (SINGULAR, 9.614938), (UPPER, 10)]}, 1e-2),
        # as polished to an error bar of 6e-9; J, whose bar is 2e-6 here, depends on switches in the second order only
        ("goddard", {"T": [(UPPER, 0.02351), (SINGULAR, 0.072672), (LOWER, 0.19885)]}, 1e-3),
        ("bryson_denham", {"displacement limit": [(INSIDE, 1 / 3), (UPPER, 2 / 3), (INSIDE, 1)]}, 0.02),
    ],
)  # fmt: skip
def test_what_is_on_which_bound_and_when(name, expected, within):
    found = arcs(name)
    for own, course in expected.items():
        assert [on for on, _ in found[own]] == [on for on, _ in course]
        assert [end for _, end in found[own]] == pytest.approx([end for _, end in course], abs=within)


@pytest.mark.parametrize("name", [SMOOTH, UNBOUNDED, DECAY, "cartpole", *(["delta_iii"] if ALL else [])])
def test_nothing_is_said_where_no_bound_acts(name):
    """Not of a control that decays to its bound either, nor of one that an equation holds."""
    solution, _ = solved(name)
    assert solution.solved and not any(solution.arcs)


def test_a_bound_that_is_touched_at_one_time():
    """Bryson and Denham's problem with a limit between 1/6 and 1/4."""
    spec = load_file("bryson_denham", ["parameters.l=0.2"])
    (problems,) = build_checked([spec])
    ((course,),) = solve_spec(spec, problems).arcs
    assert [arc.on for arc in course.arcs] == [INSIDE, UPPER, INSIDE]
    assert course.arcs[1].start == course.arcs[1].end == pytest.approx(0.5, abs=0.02)


def test_each_phase_has_its_own_arcs():
    assert arcs("goddard_three_phases", phase=1)["T"][0][0] == SINGULAR
    assert solved("goddard_three_phases")[0].arcs[0] == ()


@pytest.fixture(scope="module")
def goddard(tmp_path_factory):
    """The result file of Goddard's rocket."""
    path = tmp_path_factory.mktemp("arcs") / "goddard.h5"
    solution, spec = solved("goddard")
    write(path, solution, spec.text, spec.model_dump_json(), "trajopt solve goddard")
    return path


def test_the_arcs_are_in_the_result_and_in_what_is_told_of_it(goddard):
    (own, mass) = summarize(goddard)["phases"]["main"]["arcs"]
    assert (own["name"], own["kind"], mass["name"]) == ("T", "control", "m")
    assert [arc["by"] for arc in own["arcs"]] == ["", "singular", ""]
    assert [arc["bound"] for arc in own["arcs"]] == [3.5, None, 0]
    assert own["arcs"][0]["end"] == own["arcs"][1]["start"]


def test_show_tells_them_in_words_and_as_json(goddard):
    run = trajopt("show", goddard)
    assert run.exit_code == 0
    assert "\narcs        T: max until 0.02" in run.stdout
    assert ", singular until 0.0722" in run.stdout and ", then 0\n" in run.stdout


def told(*courses):
    """The words for (name, kind, arcs) each; an arc is (on, end, bound) or (on, end, bound, by)."""
    phases = {"main": {"arcs": [], "time": {"initial": 0, "final": 1}}}
    for name, kind, given in courses:
        start, found = 0.0, []
        for on, end, bound, *by in given:
            found.append({"on": on, "start": start, "end": end, "bound": bound, "by": by[0] if by else ""})
            start = end
        phases["main"]["arcs"].append({"name": name, "kind": kind, "arcs": found})
    return list(few_arcs(phases))


def test_words():
    bangs = ("u", CONTROL, [(UPPER, 13.73, 2), (INSIDE, 21.99, None, SINGULAR), (LOWER, 42, 0)])
    touch = ("x", STATE, [(INSIDE, 0.5, None), (UPPER, 0.5, 1), (INSIDE, 1, None)])
    always = ("w", CONTROL, [(LOWER, 1, -1)])
    many = ("chatter", PATH, [((LOWER, UPPER)[t % 2], t, -1) for t in range(1, 10)])
    assert told(touch, bangs, many, always) == [
        "u: max until 13.73, singular until 21.99, then 0",
        "w: min throughout",
        "x: inside until 0.5, touching max there, then inside",
        "and 1 more: trajopt show",
    ]
    assert told(many) == ["chatter: 9 arcs, on its bounds and off them"]
    assert told() == []


def test_phases_one_after_the_other_are_told_together():
    def phase(start, end, **arcs):
        own = [
            {"name": name, "kind": CONTROL, "arcs": [{"start": start, "end": end, "by": "", **arc}]}
            for name, arc in arcs.items()
        ]
        return {"time": {"initial": start, "final": end}, "arcs": own}

    top, low = {"on": UPPER, "bound": 1}, {"on": LOWER, "bound": 0}
    phases = {"a": phase(0, 1, u=top, w=top), "b": phase(1, 2, u=top), "c": phase(2, 3, u=low, w=low)}
    assert list(few_arcs(phases)) == ["u: max until 2, then 0", "a, w: max throughout", "c, w: 0 throughout"]
    apart = {**phases, "c": phase(2.5, 3, u=low)}
    assert "c, u: 0 throughout" in list(few_arcs(apart))


MESH = Mesh.of(find("trapezoid"), 6)
POINTS = [group.nodes for group in MESH.groups]


def runs(on, acts=lambda start, end: True, smeared=None):
    found = arcs_of(np.array(on), POINTS, MESH, np.arange(7.0), acts, lambda a, b: (a + 1 + b) / 2, smeared)
    return [(arc.on, arc.start, arc.end) for arc in found]


def test_points_on_bounds_become_arcs_of_whole_segments():
    assert runs([1, 1, 1, 0, 0, -1, -1]) == [(UPPER, 0, 2.5), (INSIDE, 2.5, 4.5), (LOWER, 4.5, 6)]
    assert runs([1, 1, 1, 1, -1, -1, -1]) == [(UPPER, 0, 3.5), (LOWER, 3.5, 6)]
    assert runs([0, 1, 0, 1, 0, 1, 0]) == [(INSIDE, 0, 6)]  # no whole segment
    assert runs([1, 1, 0, 0, 0, 0, 0], acts=lambda start, end: start > 0) == [(INSIDE, 0, 6)]
    smeared = np.arange(6) == 2
    assert runs([1, 1, 0, 0, -1, -1, -1], smeared=smeared) == [(UPPER, 0, 2.5), (LOWER, 2.5, 6)]


def test_switches_of_a_state_are_those_of_a_control_nearby_and_touches_are_no_ends():
    found = snapped([Arc(0, 0.99, INSIDE), Arc(0.99, 2, UPPER), Arc(2, 3, INSIDE)], [1, 2.3])
    assert [(arc.start, arc.end) for arc in found] == [(0, 1), (1, 2), (2, 3)]
    touched = with_touches(found, [(0.5, UPPER), (0.999, UPPER), (1.5, UPPER)])
    assert [(arc.start, arc.end) for arc in touched] == [(0, 0.5), (0.5, 0.5), (0.5, 1), (1, 2), (2, 3)]


def test_the_arc_and_the_bound_of_a_time():
    course = Course("u", CONTROL, Range(-1, 3), (Arc(0, 1, UPPER), Arc(1, 2, INSIDE)))
    assert course.at(0.5).on == UPPER and course.at(1.5).on == INSIDE and course.at(9).on == INSIDE
    assert course.bound(course.arcs[0]) == 3 and np.isnan(course.bound(course.arcs[1]))


def test_an_arc_of_no_duration_is_held_by_nothing():
    """As where a control is cut at a touch of the bound: a share of it is a share of nothing."""
    wall = Course("x", STATE, Range(0, 1), (Arc(0.0, 2.0, UPPER), Arc(2.0, 3.0, INSIDE)))
    assert [_share(wall, Arc(a, b, INSIDE)) for a, b in ((1.0, 1.0), (2.0, 2.0), (1.0, 3.0))] == [0, 0, 0.5]
