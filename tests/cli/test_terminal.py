"""What a terminal shows: tables that keep to its width, the line that lives while IPOPT iterates, colours."""

import os
import pty
import re
import subprocess
from pathlib import Path

import pytest
from command_line import TRAJOPT, process, solved_once, trajopt

from trajopt.problems.catalog import shipped

pytestmark = pytest.mark.usefixtures("folder")

STYLE = re.compile(r"\x1b\[[\d;]*m")


def on_a_terminal(*arguments: str, columns: int = 80, **variables: str) -> str:
    """What a terminal of that width receives; standard output and error together."""
    primary, secondary = pty.openpty()
    environment = {**os.environ, "COLUMNS": str(columns), "TERM": "xterm", **variables}
    started = subprocess.Popen([*TRAJOPT, *arguments], stdout=secondary, stderr=secondary, env=environment)
    os.close(secondary)
    received = b""
    try:
        while block := os.read(primary, 4096):
            received += block
    except OSError:  # Linux's way to say that the other side has closed
        pass
    os.close(primary)
    assert started.wait() == 0
    return received.decode()


def plain(shown: str) -> list[str]:
    """The lines without styles."""
    return STYLE.sub("", shown).replace("\r", "").rstrip("\n").split("\n")


@pytest.mark.parametrize("columns", [30, 80])
def test_the_live_line_appears_and_vanishes(columns):
    shown = on_a_terminal("solve", "cartpole", "--segments", "400", columns=columns)
    live, table = shown.rsplit("\x1b[2K", 1)
    assert live.startswith("\x1b[?25lcart-pole swing-up: building") and "\x1b[?25h" in live  # the cursor comes back
    lines = [STYLE.sub("", line).rstrip("\r\n") for line in live.split("\r\x1b[2K")]
    assert any(re.search(r"mesh \d, iter" if columns > 30 else r"mesh \d", line) for line in lines)
    assert all(len(line.partition("\r")[0].removeprefix("\x1b[?25l")) <= columns for line in lines)
    assert table.startswith("\x1b[32m\x1b[1mcart-pole swing-up: solved\x1b[0m\r\n")
    assert max(map(len, plain(table))) <= max(columns, 36)


@pytest.mark.parametrize("arguments", [("-q",), ("--verbose",)])
def test_no_live_line_where_it_would_be_in_the_way(arguments):
    assert "building" not in on_a_terminal("solve", "cartpole", *arguments)


def test_a_dumb_terminal_gets_no_codes():
    shown = on_a_terminal("solve", "cartpole", TERM="dumb")
    assert shown.startswith("cart-pole swing-up: solved")
    assert "building" not in shown and "\x1b" not in shown
    assert "\x1b" not in on_a_terminal("list", TERM="dumb")


def test_no_color():
    solved_once(Path("a.h5"), "cartpole")
    shown = on_a_terminal("show", "a.h5", NO_COLOR="1")
    assert set(STYLE.findall(shown)) <= {"\x1b[1m", "\x1b[0m"}  # bold is no colour
    assert "\x1b[32m" in on_a_terminal("show", "a.h5")


@pytest.mark.parametrize("columns", [80, 100])
def test_tables_on_a_terminal_keep_to_its_width_and_lose_nothing(columns):
    lines = plain(on_a_terminal("list", columns=columns))
    assert max(map(len, lines)) <= columns
    assert [line.split()[0] for line in lines if line[0] != " "] == ["name", *shipped()]
    assert "".join(sorted("".join(lines))).split() == "".join(sorted(trajopt("list").stdout.replace("\n", ""))).split()


def test_a_table_too_wide_for_a_terminal_is_left_to_it():
    assert "\n".join(plain(on_a_terminal("list", columns=40))) == trajopt("list").stdout.rstrip("\n")


def test_a_pipe_gets_whole_lines_whatever_the_environment_says():
    environment = {**os.environ, "COLUMNS": "20", "FORCE_COLOR": "1", "TTY_COMPATIBLE": "1"}
    run = process("list", env=environment)
    assert "\x1b" not in run.stdout
    assert len(run.stdout.splitlines()) == 1 + len(shipped())
    assert all(line == line.rstrip() for line in run.stdout.splitlines())


def test_names_are_no_markup():
    solved_once(Path("[red]a.h5"), "cartpole")
    lines = trajopt("compare", "[red]a.h5").stdout.splitlines()
    assert lines[1].startswith("[red]a.h5  hermite-simpson")
