"""Versions by the names of folders: those that the standard library tells."""

import importlib.metadata
import sys

import pytest

from trajopt.problems.lean.versions import version


@pytest.mark.parametrize("package", ["trajopt", "pyomo", "numpy", "h5py", "pydantic", "typer"])
def test_it_is_what_the_standard_library_tells(package):
    assert version(package) == importlib.metadata.version(package)


def test_the_first_folder_counts_that_has_a_whole_package(tmp_path, monkeypatch):
    for folder, name, file in (
        ("a", "parcel-9.0.dist-info", "RECORD"),  # removed, but for a file
        ("b", "parcel_post-8.0.dist-info", "METADATA"),
        ("c", "Parcel-1.2.3rc4+local.dist-info", "METADATA"),
        ("d", "parcel-7.0.dist-info", "METADATA"),
    ):
        own = tmp_path / folder / name
        own.mkdir(parents=True)
        (own / file).write_text(f"Name: parcel\nVersion: {name.partition('-')[2].removesuffix('.dist-info')}\n")
    monkeypatch.setattr(sys, "path", [str(tmp_path / "absent"), *(str(tmp_path / name) for name in "abcd")])
    assert version("parcel") == "1.2.3rc4+local"


def test_what_no_folder_tells_the_standard_library_is_asked(tmp_path, monkeypatch):
    own = tmp_path / "parcel.egg-info"
    own.mkdir()
    (own / "PKG-INFO").write_text("Metadata-Version: 2.1\nName: parcel\nVersion: 2.5\n")
    monkeypatch.syspath_prepend(str(tmp_path))
    assert version("parcel") == "2.5"
    with pytest.raises(importlib.metadata.PackageNotFoundError):
        version("no-such-package-as-this")
