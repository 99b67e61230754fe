"""What stands in the pages of `trajopt report`, where they go, and what is refused."""

import json
import re
from html.parser import HTMLParser

import h5py
import numpy as np
import pytest
from command_line import trajopt

from trajopt.results.report.page import visible

from .pages import data_of, page_of

SECTIONS = ["problem", "trajectory", "sensitivity", "motion", "accuracy", "solver", "verification", "again"]
VOID = {"meta", "img", "input", "br", "path"}


class Page(HTMLParser):
    """The identifiers, links, and texts of a page, whose tags must match."""

    def __init__(self, text):
        super().__init__()
        self.ids, self.links, self.open, self.texts, self.tags = [], [], [], [], []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        self.tags.append(tag)
        self.ids += [attributes["id"]] if "id" in attributes else []
        self.links += [attributes[key] for key in ("href", "src") if key in attributes]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        if tag not in VOID:
            assert self.open.pop() == tag

    def handle_data(self, data):
        self.texts.append(data)


def test_a_page_tells_all_of_a_result(solved, folder):
    text = page_of(solved("cartpole"), folder / "cartpole.html")
    page = Page(text)
    assert [name for name in page.ids if name in SECTIONS] == SECTIONS
    assert all(link.startswith("#") or link == "https://github.com/leeoniya/uPlot" for link in page.links)
    assert len(text) < 500_000 and "The MIT License" in text
    for told in ("Kelly 2017, section 6", "largest force of the motor", "pass"):
        assert told in text, told
    assert re.search(r"\d+ of \d+ checks fail|all \d+ checks pass", text)
    charts = data_of(text)["charts"]
    titles = [chart["title"] for chart in charts.values()]
    assert titles[:6] == ["q1", "q2", "v1", "v2", "u", "costate of q1"]
    assert {"η of each state", "part of the error bar of the objective", "infeasibility and barrier"} <= set(titles)
    assert text.count('<figure class="chart" data-chart=') == len(charts)


def test_curves_are_those_of_the_file(solved, folder):
    chart = data_of(page_of(solved("cartpole"), folder / "a.html", "--no-verify"))["charts"]["control-0"]
    with h5py.File(solved("cartpole")) as file:
        dense, points = file["phase/main/dense"], file["phase/main/points"]
        t, u, knots = dense["time"][:], dense["control/u"][:], points["control/u"][::2]
    x = np.array(chart["x"]["values"])
    line, marks, _ = (np.array(series["values"], float) for series in chart["series"])
    assert np.abs(np.interp(x, t, u) - line).max() < 1e-4
    assert np.allclose(marks[~np.isnan(marks)], knots, rtol=1e-6)
    assert [bound["value"] for bound in chart["bounds"]] == [-20, 20]
    assert (chart["unit"], chart["x"]["label"]) == ("N", "time [s]")


@pytest.mark.parametrize(
    ("name", "last", "lines"),
    [
        ("branches", 6, {"state, out": (0, 2), "state, boat": (2, 5), "state, buoy": (2, 6)}),
        ("experiments", 6, {"state, long": (0, 6), "state, short": (0, 2)}),
    ],
)
def test_phases_at_the_same_times_have_a_curve_each(solved, folder, name, last, lines):
    charts = data_of(page_of(solved(name), folder / "a.html", "--no-verify"))["charts"]
    chart = charts["state-0"]
    times = np.array(chart["x"]["values"])
    assert (np.diff(times) >= 0).all() and (times[0], times[-1]) == (0, last)
    drawn = {own["label"]: np.array(own["values"], float) for own in chart["series"] if own["kind"] == "line"}
    assert {own: (times[~np.isnan(v)][0], times[~np.isnan(v)][-1]) for own, v in drawn.items()} == lines
    for phase in lines:
        with h5py.File(solved(name)) as file:
            dense = file[f"phase/{phase.split(', ')[1]}/dense"]
            exact = np.interp(times, dense["time"][:], dense[f"state/{chart['title']}"][:])
        there = ~np.isnan(drawn[phase])
        assert np.abs(exact - drawn[phase])[there].max() < 1e-5
    errors = [own for own in charts.values() if "η" in own["title"]]
    assert errors and all((np.diff(own["x"]["values"]) >= 0).all() for own in errors)
    assert all(own["phases"] == [] for own in charts.values())


def test_what_was_measured_is_drawn(solved, folder):
    chart = data_of(page_of(solved("experiments"), folder / "a.html", "--no-verify"))["charts"]["state-0"]
    (measured,) = (own for own in chart["series"] if own["label"] == "measured")
    told = [(t, v) for t, v in zip(chart["x"]["values"], measured["values"], strict=True) if v is not None]
    assert sorted(told) == [(1, 0.62), (1, 2.4), (2, 0.36), (2, 1.4), (2, 1.5), (6, 0.2)]


def test_a_long_curve_is_thinned_and_keeps_its_spikes(solved, folder, monkeypatch):
    from trajopt.results.report import charts

    monkeypatch.setattr(charts, "SAMPLES", 100)
    monkeypatch.setattr(charts, "POINTS", 10)
    whole = data_of(page_of(solved("cartpole"), folder / "a.html", "--no-verify"))["charts"]["control-0"]
    values = whole["series"][0]["values"]
    with h5py.File(solved("cartpole")) as file:
        u = file["phase/main/dense/control/u"][:]
    assert len(values) <= 102 < len(u)
    assert [max(values), min(values)] == pytest.approx([u.max(), u.min()], rel=1e-6)


@pytest.mark.parametrize("name", ["refined", "unsolved", "pendulum", "phases", "biped"])
def test_every_kind_of_result_has_a_page(solved, folder, name):
    text = page_of(solved(name), folder / f"{name}.html", "--no-verify")
    page = Page(text)
    assert "data" in page.ids and "Not verified when this page was made" in text
    told = {
        "refined": "Where the bar comes from",
        "unsolved": "NOT SOLVED: ran out of iterations",
        "pendulum": "There is none: ",
        "phases": "Between phases",
        "biped": "swing_tibia",
    }
    assert told[name] in text
    if name == "phases":
        assert [own["name"] for own in data_of(text)["charts"]["state-0"]["phases"]] == ["weak", "strong"]


def test_texts_of_a_file_are_text(solved, folder):
    text = page_of(solved("hostile"), folder / "hostile.html")
    page = Page(text)
    assert page.tags.count("script") == 3 + ("motion" in page.ids)  # data, uPlot, charts, film
    assert not {"img", "b", "u", "i"} & set(page.tags)
    for name in ('<script>alert(1)</script> & "quoted"', "</title><img src=x onerror=alert(2)>"):
        assert any(name in own for own in page.texts), name
    assert data_of(text)["charts"]["state-0"]["unit"] == "<i>m</i>"


def test_what_cannot_be_seen_is_written_as_its_escape(solved, folder):
    assert visible("a\x1b[31m\u202eb\x00\n\tc\ud800é") == "a\\x1b[31m\\u202eb\\x00\n\tc\\ud800é"
    strange = folder / "strange.h5"
    strange.write_bytes(solved("pendulum").read_bytes())
    with h5py.File(strange, "r+") as file:
        file.attrs["command"] = "trajopt \x1b[31m solve \u202e"
        file["phase/main/points/state"].attrs["x"] = 1
    text = page_of(strange, folder / "strange.html", "--no-verify")
    assert "trajopt \\x1b[31m solve \\u202e" in text and "\x1b" not in text and "\u202e" not in text


def test_a_page_runs_its_own_scripts_only(solved, folder):
    from base64 import b64encode
    from hashlib import sha256

    text = page_of(solved("pendulum"), folder / "a.html", "--no-verify")
    (policy,) = re.findall(r'http-equiv="Content-Security-Policy" content="([^"]*)"', text)
    scripts = re.findall(r"<script>(.*?)</script>", text, re.DOTALL)
    hashes = [b64encode(sha256(script.encode()).digest()).decode() for script in scripts]
    assert policy.startswith("default-src 'none'") and len(scripts) == 3
    assert re.findall(r"'sha256-([^']*)'", policy) == hashes


def test_the_same_result_gives_the_same_page(solved, folder):
    pages = [page_of(solved("pendulum"), folder / f"{n}.html") for n in range(2)]
    assert pages[0] == pages[1]


# -- a sweep --------------------------------------------------------------------------------------------------------


def test_a_page_tells_all_of_a_sweep(swept, folder):
    text = page_of(swept, folder / "swept.html")
    Page(text)
    data = data_of(text)["sweep"]
    columns = {column["name"]: column for column in data["columns"]}
    records = [json.loads(line) for line in (swept / "index.jsonl").read_text().splitlines()]
    by_case = {record["case"]: record for record in records}
    assert columns["case"]["numbers"] == list(range(12))
    objectives = [by_case[n]["objective"] for n in range(12)]
    assert columns["objective"]["numbers"] == pytest.approx(objectives, rel=1e-6)
    assert [axis["texts"] for axis in data["axes"]] == [["0.5", "4.5", "5", "6", "8", "12"], ["4", "8"]]
    assert data["axes"][1]["of"] == [0, 1] * 6 and data["axes"][0]["numbers"] == [0.5, 4.5, 5, 6, 8, 12]
    assert columns["solved"]["numbers"] == [0, 0] + [1] * 10 and len(data["results"]) >= 10
    assert "10 of 12 cases solved" in text and by_case[0]["message"].split(";")[0] in text
    curves = data["curves"]["cases"]
    assert curves[0] == [] and list(curves[5][0]["values"]) == ["x", "v", "u"]
    assert len(curves[5][0]["values"]["x"]) == len(data["curves"]["grids"][curves[5][0]["grid"]])
    assert curves[5][0]["values"]["x"][-1] == pytest.approx(1)


def test_a_page_of_many_cases_leaves_their_curves_out(swept, folder, monkeypatch):
    from trajopt.results.report import sweep

    monkeypatch.setattr(sweep, "NUMBERS", 100)
    monkeypatch.setattr(sweep, "MOST_CASES", 7)
    text = page_of(swept, folder / "swept.html")
    data = data_of(text)["sweep"]
    assert data["curves"] is None and len(data["columns"][0]["numbers"]) == 7
    assert "5 more are in index.csv" in text and "10 of 12 cases solved" in text


def test_a_sweep_that_cannot_be_built_is_shown_without_its_problem(swept, folder):
    import shutil

    shutil.copytree(swept, folder / "copy")
    about = json.loads((folder / "copy" / "sweep.json").read_text())
    (folder / "copy" / "sweep.json").write_text(json.dumps({**about, "text": "trajopt: 1\nstates: {"}))
    text = page_of(folder / "copy", folder / "copy.html")
    assert "cannot read the problem of the file" in text and "10 of 12 cases solved" in text


@pytest.mark.parametrize(
    "about", ["{", "[]", '{"format": "other", "format_version": 1}', "PLAN", '{"format": 1}', "\x00", "[" * 100_000]
)
def test_a_damaged_folder_is_one_sentence(about, folder):
    (folder / "swept").mkdir()
    plan = {"format": "trajopt sweep", "format_version": 1, "design": "grid", "axes": [{"path": 3}]}
    (folder / "swept" / "sweep.json").write_text(json.dumps(plan) if about == "PLAN" else about)
    run = trajopt("report", "swept")
    assert (run.exit_code, run.stdout, run.stderr.count("\n")) == (3, "", 1)
    assert run.stderr.startswith("error: swept/sweep.json: ")
    assert not (folder / "swept.html").exists()


def test_a_folder_that_holds_no_sweep_names_the_one_inside(swept, folder):
    (folder / "empty").mkdir()
    run = trajopt("report", "empty")
    assert (run.exit_code, run.stderr) == (
        3, "error: empty: the folder holds no sweep; give a result, or the folder that 'trajopt sweep' has made\n",
    )  # fmt: skip
    run = trajopt("report", swept.parent, "-o", "a.html")
    assert run.exit_code == 3 and f"did you mean {swept}?" in run.stderr


def test_a_page_is_called_after_the_whole_name_of_a_folder(swept, folder, monkeypatch):
    import shutil

    shutil.copytree(swept, folder / "u=0.5-swept")
    run = trajopt("report", "u=0.5-swept")
    assert (run.exit_code, run.stdout) == (0, "u=0.5-swept.html\n")
    monkeypatch.chdir(folder / "u=0.5-swept")
    assert trajopt("report", ".").stdout == "u=0.5-swept.html\n"


# -- where pages go -------------------------------------------------------------------------------------------------


def test_a_page_of_trajopt_is_replaced_and_nothing_else(solved, folder):
    result = folder / "own.h5"
    result.write_bytes(solved("pendulum").read_bytes())
    for _ in range(2):
        run = trajopt("report", "own.h5", "--no-verify")
        assert (run.exit_code, run.stdout) == (0, "own.html\n")
    (folder / "own.html").write_text("<p>mine</p>")
    run = trajopt("report", "own.h5", "--no-verify")
    assert (run.exit_code, (folder / "own.html").read_text()) == (3, "<p>mine</p>")
    assert "it exists and is no page of 'trajopt report'" in run.stderr
    assert trajopt("report", "own.h5", "--no-verify", "--force").exit_code == 0


@pytest.mark.parametrize(
    ("arguments", "code", "told"),
    [
        (["missing.h5"], 3, "there is no such file"),
        (["own.h5", "-o", "page.pdf"], 2, 'no page is written with the suffix ".pdf"'),
        (["own.h5", "-o", "none/page.html"], 3, "its folder does not exist"),
        (["own.h5", "own.h5"], 2, "two of them would go to this file"),
        (["own.html", "-o", "page.html"], 3, "it cannot be read as HDF5"),
    ],
)
def test_mistakes_are_sentences(arguments, code, told, folder):
    (folder / "own.html").write_text("mine")
    run = trajopt("report", *arguments)
    assert (run.exit_code, run.stdout) == (code, "") and told in run.stderr
    assert [path.name for path in folder.iterdir()] == ["own.html"]
