"""`trajopt reproduce library`: the shipped problems beside published values, the kept baseline, and what is worse;
tests/reproduction/library.py solves all of them."""

import json
from dataclasses import replace
from html.parser import HTMLParser

import pytest
from command_line import strict_json, trajopt
from repository import ROOT

from trajopt.problems.build import build_all
from trajopt.problems.catalog import shipped
from trajopt.problems.load import load
from trajopt.results.library import baseline as kept
from trajopt.results.library.baseline import baseline, baseline_text, regressions, renewed
from trajopt.results.library.rows import COMPLETE, EXCLUDED, FINE, SHORT, SLOW, Finer, Row, row_from, row_of
from trajopt.results.library.solve import finest, solve_one
from trajopt.results.library.table import cells, library_html, markdown
from trajopt.transcription.continuation import solve_spec

BASELINE = baseline()
HOW = "trajopt reproduce library writes library.md and baseline.json anew"

# -- what is kept ---------------------------------------------------------------------------------------------------


def test_the_page_is_that_of_the_baseline():
    assert (ROOT / "docs" / "library.md").read_text() == markdown([*BASELINE.values()]), HOW


def test_the_baseline_has_every_shipped_problem():
    assert list(BASELINE) == list(shipped()), HOW
    assert set(BASELINE) >= SLOW


def test_the_baseline_is_as_it_would_be_written():
    text = (ROOT / "results" / "library" / "baseline.json").read_text()
    assert text == baseline_text([*BASELINE.values()]), HOW
    assert "seconds" not in text


def test_the_digits_that_are_published_are_ours_or_off():
    told = [row for row in BASELINE.values() if row.standing]
    settled = [row for row in told if row.standing != SHORT]
    assert len(settled) >= 0.95 * len(told), [row.name for row in told if row.standing == SHORT]
    assert all(row.finer for row in settled if row.standing != COMPLETE)


def test_every_kept_problem_is_solved_and_agrees_with_its_reference():
    assert [name for name, row in BASELINE.items() if not row.solved or row.holds is False] == []
    assert [name for name, row in BASELINE.items() if not row.difference <= row.tolerance] == []


@pytest.mark.parametrize("name", ["bryson_denham", "fuller", "speed_limit"])
def test_a_solve_for_more_digits_ends_at_its_limit(name):
    spec = load(shipped()[name])
    solution = solve_spec(spec, build_all(spec))
    row = row_of(name, spec, solution, [], (0.0, 0.0))
    assert row.complete is False
    assert finest(row, spec, solution, seconds=0.0) == row
    assert finest(row, spec, solution).finer


# -- what is worse --------------------------------------------------------------------------------------------------

GOOD = Row(
    name="swing", tags=("robotics",), solved=True, message="solved", objective=2.5000001, bar=2e-6, reference=2.5,
    tolerance=1e-6, source="exact: 5/2", segments=40, points=81, meshes=3, iterations=60, checks=17, failed=("H",),
    seconds=1.5, verify_seconds=0.5,
)  # fmt: skip


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"solved": False, "message": "ran out of iterations"}, "was solved, now: ran out of iterations"),
        ({"objective": 2.6}, "another optimum, objective 2.5000001 before, 2.6 now, error bars 2.0e-06 and 2.0e-06"),
        ({"objective": 2.4}, "another optimum, objective 2.5000001 before, 2.4 now"),
        ({"objective": 2.500002}, "7.4 digits agreed with the reference before, 6.1 now"),
        ({"bar": None}, "error bar 2.0e-06 before, none now"),
        ({"bar": 2.1e-5}, "error bar 2.0e-06 before, 2.1e-05 now"),
        (
            {"objective": 2.500003, "bar": 1e-6},
            "the error bar held before, now it is 1.0e-06 and the reference 3.0e-06",
        ),
        ({"iterations": 73}, "60 iterations before, 73 now"),
        ({"failed": ("H", "dynamics")}, "1 checks of verify failed before, 2 now: dynamics"),
        ({"failed": ("dynamics",)}, "1 checks of verify failed before, 1 now: dynamics"),
    ],
)
def test_what_is_worse_is_told_with_the_name_and_both_values(change, told):
    found = regressions({"swing": GOOD}, [replace(GOOD, **change)])
    assert any(line.startswith(f"swing: {told}") for line in found), found


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"iterations": 72},
        {"iterations": 20},
        {"objective": 2.5},
        {"objective": 2.5000007},
        {"bar": 1e-6},
        {"bar": 1.9e-5},
        {"failed": ()},
        {"seconds": 100.0, "verify_seconds": 100.0},
        {"segments": 80, "meshes": 7},
    ],
)
def test_what_is_as_good_is_not_told(change):
    assert regressions({"swing": GOOD}, [replace(GOOD, **change)]) == []


LONG = 2.512345678
TOLD = {
    COMPLETE: replace(GOOD, objective=LONG, reference=LONG, source="own"),
    FINE: replace(GOOD, objective=LONG + 2e-9, reference=LONG, source="own", finer=Finer("--polish", LONG, 1e-9)),
    EXCLUDED: replace(
        GOOD, objective=LONG + 2e-9, reference=LONG, source="own", finer=Finer("--polish", LONG + 1e-8, 1e-9)
    ),
}
"""Rows of a reference of ten digits, by their standing."""


@pytest.mark.parametrize("standing", TOLD)
@pytest.mark.parametrize(
    ("finer", "told"),
    [
        (None, "not now (no finer solve is better)"),
        (Finer("--polish", LONG + 1e-9, 2e-9), "not now (the finer solve: --polish gives 2.512345679 +- 2.0e-09)"),
    ],
)
def test_a_published_digit_that_the_finer_solve_lost_is_told(standing, finer, told):
    before, now = TOLD[standing], replace(TOLD[FINE], finer=finer)
    assert (before.standing, now.standing) == (standing, SHORT)
    (line,) = regressions({"swing": before}, [now])
    assert line.startswith("swing: all published digits were told before")
    assert told in line
    assert regressions({"swing": before}, [now], finer=False) == []
    assert regressions({"swing": now}, [now]) == [] == regressions({"swing": now}, [before])


def test_bars_within_rounding_may_vary():
    """Where the mesh is exact, the bar is what the solver's rounding leaves."""
    fine = replace(GOOD, bar=1e-11)
    assert regressions({"swing": fine}, [replace(fine, bar=3e-7)]) == []
    assert regressions({"swing": fine}, [replace(fine, bar=4e-7)]) == ["swing: error bar 1.0e-11 before, 4.0e-07 now"]


def test_few_iterations_more_are_no_loss():
    few = replace(GOOD, iterations=6)
    assert regressions({"swing": few}, [replace(few, iterations=10)]) == []
    assert regressions({"swing": few}, [replace(few, iterations=11)]) == ["swing: 6 iterations before, 11 now"]


def test_checks_that_were_not_made_are_not_compared():
    unchecked = replace(GOOD, checks=0, failed=())
    assert regressions({"swing": GOOD}, [unchecked]) == [] == regressions({"swing": unchecked}, [GOOD])


def test_a_new_problem_has_nothing_to_be_worse_than():
    assert regressions({}, [GOOD]) == []


def test_an_unsolved_problem_that_stays_so_is_not_told_again():
    unsolved = replace(GOOD, solved=False, objective=None)
    assert regressions({"swing": unsolved}, [replace(unsolved, iterations=600)]) == []
    assert regressions({"swing": unsolved}, [GOOD]) == []


# -- rows -----------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("objective", "reference", "source", "digits"),
    [
        (12 + 1.2e-6, 12.0, "exact: appendix B", 7.0),
        (12.0, 12.0, "exact: appendix B", 8.0),  # no more than the tolerance of the solver settles
        (1.33080001, 1.3308, "Patterson", 4.4),  # half a unit of the last digit given
        (1.3318, 1.3308, "Patterson", 3.1),
        (-0.04, -0.05, "exact", 0.7),
        (34.0, 34.0, "a paper", 1.8),
        (1e-7, 0.0, "exact", 7.0),
        (0.0, 0.0, "exact", 8.0),
        (900.0, 1.0, "exact", 0.0),
        (None, 1.0, "exact", None),
        (1.0, None, "", None),
    ],
)
def test_digits_are_those_of_the_lesser_of_both(objective, reference, source, digits):
    assert replace(GOOD, objective=objective, reference=reference, source=source).digits == digits


@pytest.mark.parametrize(
    ("reference", "half"),
    [
        (1.3308, 5e-5),
        (12.0, 5e-9),
        (0.0, 5e-10),
        (7.25, 5e-3),
        (0.182818188417, 5e-11),
        (18550.8718638, 5e-6),
        (2e-3, 5e-4),
    ],
)
def test_digits_count_as_they_are_given_and_at_most_ten(reference, half):
    row = replace(GOOD, reference=reference)
    assert row.half_digit == pytest.approx(half)
    assert replace(row, objective=reference + 0.99 * half).complete is True
    assert replace(row, objective=reference - 1.01 * half).complete is False
    assert replace(row, reference=None).complete is None


@pytest.mark.parametrize(
    ("objective", "source", "finer", "standing"),
    [
        (1.33081, "Betts", None, COMPLETE),
        (1.3309, "Betts", None, SHORT),
        (1.3309, "Betts", Finer("--accuracy 1e-6", 1.33081, 1e-6), FINE),
        (1.3309, "Betts", Finer("--accuracy 1e-6", 1.3309, 1e-6), EXCLUDED),
        (1.3309, "Betts", Finer("--accuracy 1e-6", 1.3309, 6e-5), SHORT),  # the bar holds the reference
        (1.3309, "exact: by hand", Finer("--polish", 1.3309, 1e-6), SHORT),  # what is exact is not off
    ],
)
def test_fewer_digits_are_told_by_a_finer_solve(objective, source, finer, standing):
    row = replace(GOOD, objective=objective, reference=1.3308, source=source, finer=finer)
    assert row.standing == standing
    assert row_from(row.told) == row
    assert (finer is None) == (": " not in cells(row)["published digits"])


def test_a_finer_solve_is_made_where_digits_are_short(tmp_path):
    row = solve_one("singular_double_integrator", tmp_path, verified=False)
    assert row.complete is False and row.standing == FINE
    assert row.finer.bar < row.bar


@pytest.mark.parametrize(("book", "standing"), [("13.88888889", FINE), ("13.8888", EXCLUDED)])
def test_a_finer_solve_tells_a_book_that_rounds_from_one_that_errs(book, standing):
    """The speed limit's exact optimum is 125/9."""
    spec = load(shipped()["speed_limit"], [f"reference.objective={book}", "reference.source=a book"])
    solution = solve_spec(spec, build_all(spec))
    row = finest(row_of("speed_limit", spec, solution, [], (0.0, 0.0)), spec, solution)
    assert row.complete is False and row.standing == standing
    assert abs(row.finer.objective - 125 / 9) < row.finer.bar < row.bar


def test_a_bar_holds_up_to_the_tolerance_of_the_reference():
    assert replace(GOOD, objective=2.5 + 2.9e-6).holds is True
    assert replace(GOOD, objective=2.5 - 3.1e-6).holds is False
    assert replace(GOOD, bar=None).holds is None and replace(GOOD, reference=None).holds is None
    assert replace(GOOD, objective=None).holds is False
    assert replace(GOOD, failed=()).passed and not GOOD.passed


def test_a_row_comes_back_from_what_is_kept():
    assert row_from(GOOD.told) == GOOD
    again = row_from(replace(GOOD, objective=2.50000010000001234, bar=2.0432e-6).kept)
    assert again == replace(GOOD, bar=2e-6, seconds=0.0, verify_seconds=0.0)


def test_rows_of_a_run_take_the_place_of_kept_ones():
    new = replace(GOOD, name="pendulum")
    rows = renewed([new], BASELINE)
    assert [row.name for row in rows] == list(shipped())
    assert [row for row in rows if row != BASELINE[row.name]] == [new]
    assert renewed([GOOD], {}) == []  # no shipped problem


def test_html_shows_what_is_wrong_and_escapes_texts():
    odd = replace(GOOD, name="a<b", source="x & y", bar=1e-9, tolerance=1e-9)
    page = library_html([odd], ["a<b: worse"])
    tags = []
    parser = HTMLParser()
    parser.handle_starttag = lambda tag, attributes: tags.append((tag, dict(attributes).get("class")))
    parser.feed(page)
    assert tags.count(("span", "fail")) == 2 and tags.count(("p", "fail")) == 2
    assert "a&lt;b: worse" in page and "x &amp; y" in page and "a<b" not in page


# -- the command ----------------------------------------------------------------------------------------------------

TWO = ("--only", "shot_put", "--only", "block_move_min_force")


def test_the_command_writes_all_tables(folder):
    run = trajopt("reproduce", "library", *TWO, "--check", "-j", "2", "-o", "mine")
    assert (run.exit_code, run.stderr) == (0, "")
    lines = run.stdout.splitlines()
    assert lines[0].split()[:3] == ["problem", "objective", "error"]
    assert [line.split()[0] for line in lines[1:3]] == ["block_move_min_force", "shot_put"]  # as listed
    assert lines[-3:] == [
        "2 problems: 2 solved, 2 verified, the error bar holds in 2 of 2; all published digits in 2 of 2 "
        "(2 by default, 0 by a finer solve, 0 where they are off)",
        "compared with the baseline: 0 regressions",
        "mine/index.html",
    ]
    made = strict_json((folder / "mine" / "library.json").read_text())
    assert [row["name"] for row in made["problems"]] == ["block_move_min_force", "shot_put"]
    assert all(row["seconds"] > 0 and row["digits"] >= 7 and row["holds"] for row in made["problems"])
    assert made["regressions"] == []
    text = (folder / "mine" / "library.md").read_text()
    assert text.partition("## First tries")[0].count("\n| ") == 2 + len(shipped())
    assert len(strict_json((folder / "mine" / "baseline.json").read_text())["problems"]) == len(shipped())
    assert sorted(path.stem for path in (folder / "mine" / "results").iterdir()) == ["block_move_min_force", "shot_put"]
    assert trajopt("verify", "mine/results/shot_put.h5").exit_code == 0
    assert "<td>shot_put</td>" in (folder / "mine" / "index.html").read_text()


def test_what_is_worse_ends_with_exit_code_1(folder, monkeypatch):
    """The baseline claims fewer iterations and another optimum than there are."""
    old = {**BASELINE, "shot_put": replace(BASELINE["shot_put"], iterations=1, objective=22.0)}
    monkeypatch.setattr(kept, "baseline", lambda: old)
    run = trajopt("reproduce", "library", "--only", "shot_put", "--check", "--json")
    told = json.loads(run.stdout)
    now = told["problems"][0]["iterations"]
    assert run.exit_code == 1 and told["passed"]
    assert [line for line in told["regressions"] if line.endswith(f"1 iterations before, {now} now")]
    assert [line for line in told["regressions"] if line.startswith("shot_put: another optimum, objective 22 before")]
    assert "another optimum" in (folder / "library" / "index.html").read_text()
    assert trajopt("reproduce", "library", "--only", "shot_put").exit_code == 0  # not asked to compare


@pytest.mark.parametrize(
    ("arguments", "told"),
    [
        (
            ("library", "--only", "shot_putt"),
            "--only shot_putt: there is no such shipped problem; did you mean shot_put?",
        ),
        (("library", "--only", "goddard", "--fast"), "--fast: goddard takes long, so nothing is left"),
        (("library", "cartpole"), "cartpole: library stands alone"),
        (("library", "-j", "none"), "--jobs"),
        (("points", "--fast"), "--fast: it is of the library only"),
        (("--only", "shot_put"), "--only: it is of the library only"),
        (("librari",), "did you mean library?"),
    ],
)
def test_mistakes_are_one_sentence_and_nothing_is_made(folder, arguments, told):
    run = trajopt("reproduce", *arguments)
    assert (run.exit_code, run.stdout) == (2, "")
    assert told in run.stderr and run.stderr.count("\n") == 1
    assert list(folder.iterdir()) == []


def test_every_wrong_name_is_told(folder):
    run = trajopt("reproduce", "library", "--only", "nothing1", "--only", "nothing2")
    assert run.exit_code == 2 and run.stderr.count("\n") == 2


@pytest.mark.parametrize("name", ["library.md", "library.json", "baseline.json", "results/shot_put.h5"])
def test_what_is_not_ours_is_not_replaced(folder, name):
    assert trajopt("reproduce", "points", "--no-figures", "-o", "mine").exit_code == 0
    (folder / "mine" / name).write_text("my own")
    run = trajopt("reproduce", "library", "--only", "shot_put", "-o", "mine")
    assert (run.exit_code, run.stdout) == (3, "")
    assert run.stderr.count("\n") == 1 and name in run.stderr
    assert (folder / "mine" / name).read_text() == "my own"


def test_a_foreign_folder_is_refused(folder):
    (folder / "library").mkdir()
    (folder / "library" / "notes.txt").write_text("mine")
    run = trajopt("reproduce", "library", "--only", "shot_put")
    assert run.exit_code == 3 and "was not made by 'trajopt reproduce'" in run.stderr
    assert [path.name for path in (folder / "library").iterdir()] == ["notes.txt"]
