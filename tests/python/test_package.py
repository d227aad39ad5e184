"""The package itself: what is committed is what C++ says, docstrings run, examples run."""

from __future__ import annotations

import doctest
import importlib
import inspect
import pkgutil
from pathlib import Path

import pytest

import lipoid
from conftest import ROOT
from lipoid import _core, _write_options

MODULES = [
    name
    for _, name, _ in pkgutil.iter_modules(lipoid.__path__, "lipoid.")
    if name not in {"lipoid._core", "lipoid._options"}
]


@pytest.mark.parametrize("name", MODULES)
def test_docstrings_run(name: str) -> None:
    module = importlib.import_module(name)
    assert doctest.testmod(module).failed == 0


def test_the_types_of_options_are_those_of_the_program() -> None:
    for file, text in _write_options.files().items():
        assert file.read_text() == text, "python -m lipoid._write_options"


def test_the_stub_names_what_the_module_has() -> None:
    stub = (ROOT / "python/lipoid/_core.pyi").read_text()
    for name, of in vars(_core).items():
        if name.startswith("_"):
            continue
        assert f"def {name}(" in stub or f"class {name}:" in stub or f"\n{name}: " in stub, name
        if inspect.isclass(of):
            body = stub.split(f"class {name}:")[1].split("\nclass ")[0].split("\ndef ")[0]
            for member in vars(of):
                assert member.startswith("_") or f"def {member}(" in body, (name, member)


@pytest.mark.parametrize("name", ["identify", "compare", "study", "plan", "fly", "Log", "read_log"])
def test_options_stand_in_docstring_and_signature(name: str) -> None:
    function = getattr(lipoid, name)
    document = inspect.getdoc(function)
    assert document is not None and "{options}" not in document
    parameters = inspect.signature(function).parameters
    assert "options" not in parameters
    for option in parameters.values():
        if option.kind is inspect.Parameter.KEYWORD_ONLY:
            assert f"{option.name} :" in document or f", {option.name}" in document, option.name


def test_the_version_is_that_of_the_sources() -> None:
    assert f"VERSION {lipoid.__version__} " in (ROOT / "CMakeLists.txt").read_text()


def test_the_example_of_the_readme_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    text = (ROOT / "README.md").read_text()
    section = text.split("## Python", 1)[1]
    example = section.split("```python\n", 1)[1].split("```", 1)[0]
    monkeypatch.chdir(tmp_path)
    exec(compile(example, "README.md", "exec"), {})
    assert (tmp_path / "cell.json").exists()
