"""What the README tells to type: both commands install from the lock file, and the lock covers pyproject.toml."""

import re
import tomllib

import pytest
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from repository import ROOT

README = (ROOT / "README.md").read_text()
LOCK = (ROOT / "requirements.lock").read_text()
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())
PYTHONS = ("3.11", "3.12", "3.13")
NAME = "requirements.lock"

GROUPS = {"dependencies": PROJECT["project"]["dependencies"], **PROJECT["project"]["optional-dependencies"]}


def locked() -> list[Requirement]:
    return [Requirement(line) for line in LOCK.splitlines() if line and not line.lstrip().startswith("#")]


def pinned(python: str) -> dict[str, str]:
    """Name -> the one version of the lock for Linux and this Python."""
    machine = {"python_version": python, "python_full_version": f"{python}.0", "sys_platform": "linux"}
    found = [r for r in locked() if r.marker is None or r.marker.evaluate(machine)]
    versions = {canonicalize_name(r.name): str(r.specifier).removeprefix("==") for r in found}
    assert len(versions) == len(found), "a package has two versions"
    return versions


def uncovered(requirements: list[str], versions: dict[str, str]) -> list[str]:
    """The requirements that no version of the lock meets."""
    parsed = [Requirement(text) for text in requirements]
    return [
        str(r)
        for r in parsed
        if not (version := versions.get(canonicalize_name(r.name))) or not r.specifier.contains(version)
    ]


def test_both_commands_install_from_the_lock():
    blocks = [block.splitlines() for block in re.findall(r"^```sh\n(.*?)^```", README, re.DOTALL | re.MULTILINE)]
    commands = [block for block in blocks if "venv" in block[0]]
    assert [len(block) for block in commands] == [1, 1]  # each is one line to copy
    assert README.count("pip install") == 2
    begin = rf"python3 -m venv \.venv && \.venv/bin/pip install -q -c {re.escape(NAME)} "
    (solve,), (test,) = commands
    assert re.fullmatch(rf"{begin}\. && \.venv/bin/trajopt solve \S+", solve)
    assert re.fullmatch(rf"{begin}'\.\[test\]' && \.venv/bin/python -m pytest -n auto", test)
    assert (ROOT / solve.split()[-1]).is_file()


def test_the_newest_lane_tests_what_there_is():
    rooms = re.search(r"^touched='(.*?)'", (ROOT / ".ci" / "run").read_text(), re.DOTALL | re.MULTILINE)[1].split()
    assert len(rooms) > 20 and [room for room in rooms if not (ROOT / room).exists()] == []


def test_every_line_of_the_lock_is_a_constraint_for_pip():
    assert locked()
    for requirement in locked():
        assert re.fullmatch(r"==[^*,]+", str(requirement.specifier)), requirement
        assert not requirement.extras and not requirement.url, requirement  # pip refuses these in a constraint


@pytest.mark.parametrize("python", PYTHONS)
@pytest.mark.parametrize("group", GROUPS)
def test_the_lock_meets_pyproject(group, python):
    assert not uncovered(GROUPS[group], pinned(python))


@pytest.mark.parametrize("requirement", ["numpy>=1000", "numpy<1", "no-such-package", "PyYAML==0.1"])
def test_what_the_lock_does_not_meet_is_seen(requirement):
    assert uncovered([requirement, "numpy>=2.0"], pinned("3.11")) == [str(Requirement(requirement))]


def test_the_build_is_pinned_where_the_lock_does_not_reach():
    specifiers = [str(Requirement(text).specifier) for text in PROJECT["build-system"]["requires"]]
    assert specifiers and all(re.fullmatch(r"==[^*,]+", specifier) for specifier in specifiers)


def test_the_lock_tells_how_it_was_made():
    command = LOCK.splitlines()[1].removeprefix("#").strip()
    assert command.startswith("uv pip compile --universal ") and command.endswith(f"-o {NAME} pyproject.toml")
    options = set(command.split()) - {"-o", NAME, "pyproject.toml"}
    told = (ROOT / "docs" / "development.md").read_text()
    assert any(options < set(line.split()) for line in told.splitlines() if line.startswith("uv pip compile"))


def test_pythons_are_those_that_pyproject_names():
    named = [text.rpartition(" ")[2] for text in PROJECT["project"]["classifiers"] if "Python :: 3." in text]
    assert tuple(named) == PYTHONS
