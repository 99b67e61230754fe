"""A plugin that tells the CPU seconds of tests, with those of the processes that they wait for.

A loaded machine changes them by a quarter, not by a factor.

    PYTHONPATH=tests/helpers python -m pytest -p cpu_seconds -n 0 tests/cli
"""

import resource
from collections import Counter

import pytest

MOST = 40
SPENT: Counter[str] = Counter()


def seconds() -> float:
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(own.ru_utime + own.ru_stime for own in used)


@pytest.hookimpl(wrapper=True, tryfirst=True)
def pytest_runtest_protocol(item):
    """The fixtures of a module count for the test that is the first to ask for them."""
    began = seconds()
    result = yield
    SPENT[item.nodeid] += seconds() - began
    return result


def pytest_terminal_summary(terminalreporter):
    files: Counter[str] = Counter()
    for name, spent in SPENT.items():
        files[name.partition("::")[0]] += spent
    for told, spent in (("files", files), ("tests", SPENT)):
        terminalreporter.section(f"CPU seconds of {told}: {sum(spent.values()):.1f}")
        for name, own in spent.most_common(MOST):
            terminalreporter.line(f"{own:8.2f}  {name}")
