"""docs/python.md and the README's Python: every example runs, in order, and shows what it says."""

import doctest
import re
from importlib.resources import files

import pytest
from repository import ROOT

PAGE = (ROOT / "docs" / "python.md").read_text()
FLAGS = doctest.ELLIPSIS | doctest.NORMALIZE_WHITESPACE


def blocks(page):
    """The Python blocks of a page: (line, text)."""
    found = re.finditer(r"^```python\n(.*?)^```$", page, re.DOTALL | re.MULTILINE)
    return [(page.count("\n", 0, match.start()) + 1, match[1]) for match in found]


def failures(page):
    """What the examples of a page show that differs from what it says, as one text."""
    scope, told = {}, []
    runner = doctest.DocTestRunner(optionflags=FLAGS)
    for line, text in blocks(page):
        test = doctest.DocTestParser().get_doctest(text, scope, "python.md", "docs/python.md", line)
        assert test.examples, f"the block at line {line} has no example"
        runner.run(test, out=told.append, clear_globs=False)
        scope = test.globs
    return "".join(told)


def test_every_example_shows_what_the_page_says(folder):
    assert len(blocks(PAGE)) >= 10
    assert not failures(PAGE)
    assert [path.name for path in folder.iterdir()] == ["swing.h5"]


@pytest.mark.parametrize(
    "wrong", ["```python\n>>> 1 + 1\n3\n```\n", "```python\n>>> a = 1\n```\n\n```python\n>>> a\n```\n"]
)
def test_an_example_that_shows_something_else_is_seen(wrong):
    assert "python.md" in failures(wrong)


def test_examples_know_what_those_before_them_made():
    assert not failures("```python\n>>> a = 1\n```\n\n```python\n>>> a\n1\n```\n")


def test_the_example_of_the_readme_runs(folder):
    readme = (ROOT / "README.md").read_text()
    (example,) = [text for _, text in blocks(readme) if "import trajopt" in text]
    assert len(example.splitlines()) == 3 and "(docs/python.md)" in readme
    scope = {}
    exec(example, scope)
    assert scope["solution"].solved


def test_type_checkers_are_told_that_there_are_types():
    """In CI trajopt is installed as a wheel, so the marker is in it."""
    assert files("trajopt").joinpath("py.typed").is_file()
