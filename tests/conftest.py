"""What tests of several files share: a folder of their own to work in."""

import pytest


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which is the current one as long as the test runs."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
