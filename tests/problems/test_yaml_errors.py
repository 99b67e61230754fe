"""Whatever the YAML library raises, in any release of it, is a sentence with a line."""

import pytest
import yaml

from trajopt.problems.errors import SpecError
from trajopt.problems.yaml import document

GOOD = "a: 1\nb: [1, 2]\nc: 3\n"
EVENTS = list(yaml.parse(GOOD))


def failing(error):
    """A library that gives the first events, up to the one in the list, and then fails."""

    def parse(text, Loader):
        for number, event in enumerate(EVENTS):
            if number == 7:
                raise error
            yield event

    return parse


@pytest.mark.parametrize(
    "error",
    [
        yaml.YAMLError("a message that no table knows"),
        yaml.scanner.ScannerError(None, None, "another one", yaml.Mark("a", 0, 1, 0, GOOD, 5)),
        ValueError("chr() arg not in range"),
        RecursionError("maximum recursion depth exceeded"),
        MemoryError(),
    ],
    ids=lambda error: type(error).__name__,
)
def test_an_error_of_any_kind(monkeypatch, error):
    monkeypatch.setattr(document.yaml, "parse", failing(error))
    with pytest.raises(SpecError) as told:
        document.read_document(GOOD, "a.yaml")
    (mistake,) = told.value.mistakes
    assert mistake.where == "a.yaml:2" and mistake.what.startswith("this is not YAML (") and mistake.remedy


@pytest.mark.parametrize("text", ['a: 1\nb: "\\uD800"', 'a: 1\nb: "\\U00110000"', "a: 1\nb: %x"])
def test_characters_that_are_none(text):
    with pytest.raises(SpecError, match=r"a.yaml:2: this is not YAML"):
        document.read_document(text, "a.yaml")
