"""Loading: YAML values, overrides, warnings, places."""

import math

import broken
import pytest
import yaml

from trajopt.problems.catalog import shipped
from trajopt.problems.errors import Mistake, SpecError
from trajopt.problems.load import load, load_text
from trajopt.problems.yaml import document as yamltext


def good(*overrides: str, text: str = broken.GOOD):
    return load_text(text, "good.yaml", overrides, broken.METHODS)


@pytest.mark.parametrize(
    ("text", "value"),
    [("1", 1), ("-3", -3), ("010", 10), ("1e-8", 1e-8), ("-.5E+3", -500.0), ("2.", 2.0), ("true", True), ("yes", "yes"),
     ("on", "on"), ("null", None), ("~", None), ("", None), ("'1'", "1"), (".inf", math.inf), ("1:30", "1:30"),
     ("2020-01-01", "2020-01-01"), ("1_000", "1_000"), ("0x10", "0x10"), ("[1, a]", [1, "a"]), ("{a: 1}", {"a": 1}),
     ("9" * 5000, math.inf), ("2*pi", "2*pi")],
)  # fmt: skip
def test_yaml_values(text, value):
    assert yamltext.value_of(text, "here") == value


@pytest.mark.parametrize("loader", ["CSafeLoader", "SafeLoader"])
def test_both_yaml_parsers_agree(loader, monkeypatch):
    monkeypatch.setattr(yamltext, "_LOADER", getattr(yaml, loader))
    document = yamltext.read_document(broken.GOOD, "good.yaml")
    assert document.data["mesh"] == [{"method": "hermite-simpson", "segments": 10, "tolerance": 1e-8}]
    assert document.lines["states", "v", "rate"] == 13
    assert document.lines["guess", "keyframes", "x", 2] == 28


def test_anchors_are_copies():
    text = "a: &a {b: 1}\nc: *a\n"
    document = yamltext.read_document(text, "f")
    document.data["c"]["b"] = 2
    assert document.data == {"a": {"b": 1}, "c": {"b": 2}}


def test_a_byte_order_mark_and_windows_line_ends_are_read(tmp_path):
    path = tmp_path / "windows.yaml"
    path.write_bytes(b"\xef\xbb\xbf" + broken.GOOD.replace("\n", "\r\n").encode())
    assert load(path).name == "a good file"


@pytest.mark.parametrize(
    ("override", "path", "value"),
    [
        ("parameters.u_max=15", ("parameters", "u_max", "value"), 15),
        ("parameters.m=3", ("parameters", "m", "value"), 3),
        ("parameters.u_max.unit=N", ("parameters", "u_max", "unit"), "N"),
        ("parameters.T=3*d", ("parameters", "T", "value"), "3*d"),
        ("mesh.0.segments=50", ("mesh", 0, "segments"), 50),
        ("mesh[0].segments=[1, 2, 1]", ("mesh", 0, "segments"), (1, 2, 1)),
        ("mesh.-1.tolerance=1e-9", ("mesh", 0, "tolerance"), 1e-9),
        ("mesh.*.method=trapezoid", ("mesh", 0, "method"), "trapezoid"),
        ("states.x.upper=5", ("states", "x", "upper"), 5),
        ("states.x.final={lower: 0.5, upper: 1}", ("states", "x", "final", "lower"), 0.5),
        ("time.final=3", ("time", "final", "value"), 3),
        ("controls.u.upper=", ("controls", "u", "upper"), None),
        ("solver.mu_strategy=adaptive", ("solver", "mu_strategy"), "adaptive"),
        ("name=a = b", ("name",), "a = b"),
    ],
)
def test_overrides(override, path, value):
    found = good(override).model_dump()
    for step in path:
        found = found[step]
    assert found == value


def test_an_override_of_a_parameter_keeps_its_unit():
    assert good("parameters.m=3").parameters["m"].unit == "kg"


def test_overrides_apply_in_turn_and_to_all():
    two = broken.GOOD.replace("mesh:\n", "mesh:\n  - {method: trapezoid, segments: 5}\n")
    spec = good("mesh.*.segments=7", "mesh.-1.segments=9", text=two)
    assert [mesh.segments for mesh in spec.mesh] == [7, 9]


def test_an_override_of_a_linear_guess():
    before, after = broken.GOOD.split("\nguess:\n")
    linear = before + "\nguess: linear\n" + after[after.index("mesh:") :]
    assert good("guess.constants.u=2", text=linear).guess.constants["u"].text == "2"


def test_an_override_does_not_reach_through_an_anchor():
    shared = broken.GOOD.replace("u: {note: force, lower", "u: &u {note: force, lower").replace(
        "optimize:", "  w: *u\noptimize:"
    )
    spec = good("controls.w.upper=1", text=shared.replace("u - c*v", "u + w - c*v"))
    assert spec.controls["u"].upper.text == "u_max" and spec.controls["w"].upper.text == "1"


def test_solver_options():
    options = (
        "max_iter: 50, mu_strategy: adaptive, warm_start_init_point: yes, honor_original_bounds: true, mu_init: 1e-2"
    )
    spec = good(f"solver={{{options}}}")
    assert spec.solver.accept == "optimal"
    assert spec.solver.options == {
        "max_iter": 50,
        "mu_strategy": "adaptive",
        "warm_start_init_point": "yes",
        "honor_original_bounds": "yes",
        "mu_init": 1e-2,
    }


@pytest.mark.parametrize(
    ("old", "new", "place", "says"),
    [
        ("  d: 1.0", "  d: 1.0\n  k: 3", "7: parameters.k", "the parameter k is used nowhere"),
        ("  u: {", "  w: {}\n  u: {", "15: controls.w", "the control w is used nowhere"),
        ("  c: {", "  p: {}\n  c: {", "17: optimize.p", "the static parameter p is used nowhere"),
        ("  power:", "  speed: v\n  power:", "9: expressions.speed", "the expression speed is used nowhere"),
        ("guess: 0.3", "guess: 3", "17: optimize.c.guess", "the guess 3 lies outside the bounds 0.1 to 0.5"),
        ("constants: {u: 1}", "constants: {u: 9}", "27: guess.constants.u", "9 lies outside the bounds -5 to 5"),
        ("x: [0, 0.5, 1]", "x: [0, 8*d, 1]", "28: guess.keyframes.x", "the guess 8 lies outside"),
        ("final: T}", "final: {lower: 1, upper: 2, guess: 3}}", "10: time.final.guess", "the guess 3 lies outside"),
    ],
)
def test_warnings(old, new, place, says):
    (warning,) = (w for w in good(text=broken.GOOD.replace(old, new)).warnings if "T is used" not in w.what)
    assert warning.where == f"good.yaml:{place}" and says in str(warning)


def test_warnings_of_dynamics_and_slack():
    algebraic = "algebraic: {F: {}, G: {}}\nresiduals: [F - u + G, u - 2*v]\noptimize:"
    spec = good(text=broken.GOOD.replace("optimize:", algebraic).replace("(u - c*v)/m", "(F - c*v)/m"))
    assert [w.where for w in spec.warnings] == ["good.yaml:17: residuals.1"]
    assert "restricts the states" in spec.warnings[0].what
    spec = good(text=broken.GOOD.replace("(u - c*v)/m", "(u - c*abs(v))/m") + "nonsmooth: slack\n")
    assert [w.where for w in spec.warnings] == ["good.yaml:13: states.v.rate"]
    assert '"abs(v)" in "(u - c*abs(v))/m" stands where slack' in spec.warnings[0].what


@pytest.mark.parametrize("option", ["hsllib=a.so", "output_file=a.txt", "pardisolib=a.so"])
def test_the_command_line_may_load_code_and_write_files(option):
    name, _, value = option.partition("=")
    assert good(f"solver.{option}").solver.options[name] == value
    assert good(f"solver={{{name}: {value}}}").solver.options == {name: value}
    assert good(f"solver.{option}", text=broken.GOOD.replace("solver: {max_iter: 100}\n", "")).solver.options[name]


def test_the_command_line_does_not_excuse_the_file():
    with pytest.raises(SpecError, match=r"solver\.hsllib"):
        good("solver.max_iter=5", text=broken.GOOD.replace("max_iter: 100", "hsllib: a.so"))


@pytest.mark.parametrize("name", ["option_file_name", "Option_File_Name", "resto.option_file_name"])
@pytest.mark.parametrize("value", ["a.opt", "ipopt.opt"])
def test_not_even_the_command_line_may_name_an_option_file(name, value):
    with pytest.raises(SpecError) as raised:
        good(f"solver={{{name}: {value}}}")
    (mistake,) = raised.value.mistakes
    assert mistake.where.startswith("--set solver")
    assert "options that trajopt cannot check" in str(mistake) and "solver.NAME" in mistake.remedy


def test_engines():
    assert good().solver.engine == "ipopt"
    free = ("states.x.lower", "states.x.upper", "controls.u", "optimize.c", "constraints")
    spec = good("solver={engine: newton, line_search: yes}", *(f"{path}=" for path in free), "optimize.c.guess=0.3")
    assert spec.solver.engine == "newton" and spec.solver.options == {"line_search": "yes"}


@pytest.mark.parametrize(
    ("override", "kind", "widths"),
    [
        ("nonsmooth=slack", "slack", []),
        ("nonsmooth={tanh: 0.5}", "tanh", ["0.5"]),
        ("nonsmooth.sqrt=d/10", "sqrt", ["d/10"]),
        ("nonsmooth={sqrt: [0.1]}", "sqrt", ["0.1"]),
    ],
)
def test_ways_to_treat_abs(override, kind, widths):
    spec = good(override)
    assert (spec.nonsmooth.treatment, [w.text for w in spec.nonsmooth.widths]) == (kind, widths)
    assert good().nonsmooth is None


def test_overrides_of_a_model_need_not_stand_in_the_file():
    path = shipped()["biped"]
    assert load(path, ["states.q3=", "states.q3.upper=1"]).states["q3"].upper.text == "1"
    with pytest.raises(SpecError, match="q9"):
        load(path, ["states.q9.upper=1"])


def test_overrides_of_residuals():
    implicit = broken.IMPLICIT
    for override in ("residuals.0=m*v[rate] - 2*F", "residuals.0.expression=m*v[rate] - 2*F"):
        assert good(override, text=implicit).residuals[0].expression.text == "m*v[rate] - 2*F"
    assert good("residuals.1.expression=F - u", text=implicit).residuals[1].name == "force"
    assert good("algebraic.F.upper=3", text=implicit).algebraic["F"].upper.text == "3"


def test_later_mistakes_are_placed_in_the_file():
    spec = good("solver.mu_init=2")
    found = spec.locate(Mistake(path, "a", "b") for path in ("solver.max_iter", "solver.mu_init", "mesh.0"))
    assert [m.where for m in found] == ["good.yaml:31: solver.max_iter", "--set solver.mu_init", "good.yaml:30: mesh.0"]


def test_a_misspelt_key_is_not_missing_as_well():
    with pytest.raises(SpecError) as error:
        good(text=broken.GOOD.replace("rate: v,", "rates: v,"))
    assert len(error.value.mistakes) == 1


def test_many_mistakes_are_cut_short():
    states = "".join(f"  y{i}: {{rate: q{i}}}\n" for i in range(900))
    with pytest.raises(SpecError) as error:
        good(text=broken.GOOD.replace("states:\n", "states:\n" + states))
    assert len(error.value.mistakes) == 101 and "more mistakes" in str(error.value.mistakes[-1])


def test_a_mistake_does_not_cause_others():
    """What depends on a value that is wrong is passed over."""
    for old, new in [("d: 1.0", "d: 2u"), ("d: 1.0", "d: 1/0"), ("power: u*v", "power: u^v"), ("T: 2*d", "T: 2*dd")]:
        with pytest.raises(SpecError) as error:
            good(text=broken.GOOD.replace(old, new))
        assert len(error.value.mistakes) == 1, error.value
