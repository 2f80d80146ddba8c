"""The code behind a result: what is imported, however it is spelt, what a step told of, and nothing that is prose."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

from emg2vsa.errors import DataError
from emg2vsa.pipeline import code
from emg2vsa.pipeline.code import Code, Reached
from emg2vsa.pipeline.fingerprint import Fingerprints

MODULES = {
    "__init__": "",
    "stage": '''
        """Doc."""
        from __future__ import annotations
        import json
        from typing import TYPE_CHECKING
        from emg2vsa.signals import helper
        from numpy import array as array_of
        if TYPE_CHECKING:
            from emg2vsa.types_only import T
        else:
            import emg2vsa.not_for_checkers
        X = helper.f(1)
        def late():
            import emg2vsa.late
    ''',
    "signals/__init__": "import emg2vsa.of_package",
    "signals/helper": """
        from ..deep import K
        from . import beside
        READERS = {".bdf": "emg2vsa.readers:read_bdf", ".edf": "emg2vsa.no_such"}
        def f(x):
            "Doc."
            return x * K  # why
    """,
    "signals/beside": "",
    "deep": """
        from importlib import import_module
        K = 2
        TEXT = "<p>{{ q[0] }} trials.</p>"
        import_module("emg2vsa.engine")
        import_module("library_by_name.inner")
    """,
    "readers": "import no_such_library",
    "engine": "from emg2vsa import stage",
    **dict.fromkeys(("late", "of_package", "not_for_checkers", "types_only"), ""),
    "other": "Y = 1",
}
REACHED = {
    "emg2vsa", "emg2vsa.stage", "emg2vsa.signals", "emg2vsa.signals.helper", "emg2vsa.signals.beside", "emg2vsa.deep",
    "emg2vsa.readers", "emg2vsa.engine", "emg2vsa.late", "emg2vsa.of_package", "emg2vsa.not_for_checkers",
}  # fmt: skip


@pytest.fixture
def package(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    folder = tmp_path / "emg2vsa"
    for name, text in MODULES.items():
        path = folder / f"{name}.py"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("\n".join(line[8:] if line[:8].isspace() else line for line in text.splitlines()))
    (tmp_path / "casr").mkdir()
    monkeypatch.setattr(code, "folder_of", lambda package: str(tmp_path / package))
    return folder


def reached(package: Path) -> Reached:
    """By a program that starts, looks and ends."""
    prints = Fingerprints(package.parent / "memory.json")
    found = Code(prints).reached("emg2vsa.stage")
    prints.save()
    return found


def test_used_is_what_is_imported_and_what_was_loaded_by_name(package: Path) -> None:
    found = Code(Fingerprints(package.parent / "memory.json"))
    used = found.used("emg2vsa.stage")
    assert set(used.modules.value) == REACHED - {"emg2vsa.readers", "emg2vsa.engine"}
    assert set(used.libraries.value) == {"python", "numpy"}
    more = found.used("emg2vsa.stage", ("emg2vsa.readers", "library_by_name", "json.decoder"))
    assert set(more.modules.value) == REACHED - {"emg2vsa.engine"}
    assert set(more.libraries.value) == {"python", "numpy", "no-such-library", "library-by-name"}


def test_of_a_stage_what_planning_alone_calls_imports_nothing(package: Path) -> None:
    stages = package / "pipeline" / "stages"
    stages.mkdir(parents=True)
    for folder in (stages, stages.parent):
        (folder / "__init__.py").write_text("")
    (stages / "toy.py").write_text("""
def settings(campaign, item):
    import emg2vsa.other
    return _both()
def files(campaign, item):
    import planned_library
def run(given):
    return [_inner(each) for each in given]
def _inner(each):
    import emg2vsa.deep
    return _both()
def _both():
    import library_of_both
def _told(product):
    import emg2vsa.readers
STAGE = Stage(run=run, settings=settings, files=partial(files, 1), says=lambda product: _told(product))
""")
    found = Code(Fingerprints(package.parent / "memory.json")).used("emg2vsa.pipeline.stages.toy")
    assert {"emg2vsa.deep", "emg2vsa.readers"} < set(found.modules.value)
    assert "emg2vsa.other" not in found.modules.value
    assert set(found.libraries.value) == {"python", "library-of-both", "no-such-library"}


def test_a_package_comes_before_a_module_of_its_name(package: Path) -> None:
    code = Code(Fingerprints(package.parent / "memory.json"))
    before = code.used("emg2vsa.deep").modules.value
    (package / "deep").mkdir()
    (package / "deep" / "__init__.py").write_text("K = 5")
    after = Code(Fingerprints(package.parent / "memory.json")).used("emg2vsa.deep").modules.value
    assert before["emg2vsa.deep"] != after["emg2vsa.deep"]


def test_everything_imported_or_named_is_reached(package: Path) -> None:
    assert set(reached(package).modules.value) == REACHED
    assert set(reached(package).modules.value) == REACHED  # remembered


def test_libraries_are_derived_with_their_versions(package: Path) -> None:
    import numpy

    found = reached(package).libraries.value
    assert set(found) == {"python", "numpy", "no-such-library", "library-by-name"}
    assert found["numpy"] == numpy.__version__
    assert found["no-such-library"] == "absent"


@pytest.mark.parametrize(
    ("file", "old", "new", "changed"),
    [
        ("deep.py", "K = 2", "K = 3", {"emg2vsa.deep"}),
        ("signals/__init__.py", "import", "Z = 1; import", {"emg2vsa.signals"}),
        ("stage.py", "f(1)", "f(2)", {"emg2vsa.stage"}),
        ("late.py", "", "Z = 1", {"emg2vsa.late"}),
        ("deep.py", "trials.", "presses.", {"emg2vsa.deep"}),
        ("signals/helper.py", "# why", "# because", set()),
        ("signals/helper.py", '"Doc."', '"Another text."', set()),
        ("stage.py", '"""Doc."""', '"""Changed."""', set()),
        ("other.py", "Y = 1", "Y = 2", set()),
        ("types_only.py", "", "T = 1", set()),
    ],
)
def test_what_counts_as_a_change(package: Path, file: str, old: str, new: str, changed: set[str]) -> None:
    before = reached(package).modules
    path = package / file
    assert old in path.read_text()
    path.write_text(path.read_text().replace(old, new) + "\n")
    after = reached(package).modules
    assert {name for name in after.value if after.value[name] != before.value.get(name)} == changed
    assert (after.digest == before.digest) == (not changed)


def test_an_edit_while_a_study_runs_is_noticed_by_stages_looked_up_later(package: Path) -> None:
    found = Code(Fingerprints(package.parent / "memory.json"))
    first = found.reached("emg2vsa.stage")
    assert first.changed() == ""
    (package / "deep.py").write_text("K = 3")
    assert first.changed() == str(package / "deep.py")
    assert found.used("emg2vsa.stage").changed()
    (package / "other.py").write_text("Y = 2")
    assert found.used("emg2vsa.other").changed()  # first asked for after its edit


def test_the_texts_of_the_report_count_in_its_key(tmp_path: Path) -> None:
    """They stand in the sections, as strings; the library that fills them counts too."""
    found = Code(Fingerprints(tmp_path / "memory.json")).used("emg2vsa.pipeline.stages.report")
    assert {f"emg2vsa.report.{name}" for name in ("sections.claims", "sections.fits", "methods")} <= set(
        found.modules.value
    )
    assert "jinja2" in found.libraries.value
    assert "emg2vsa" not in found.libraries.value


def test_what_the_server_of_workers_may_have_loaded_counts_as_loaded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    name, path = "emg2vsa.never_imported", str(Path(code.folder_of("emg2vsa")) / "never_imported.py")
    code_of = Code(Fingerprints(tmp_path / "memory.json"))
    monkeypatch.setattr(code, "_LOADED", {})
    monkeypatch.delitem(sys.modules, "multiprocessing.forkserver", raising=False)
    for size in (1, 2):  # nothing has loaded it, so the newer file is what will run
        code_of._refuse_old(name, path, (size, 0, 0, 0))
    monkeypatch.setitem(sys.modules, "multiprocessing.forkserver", sys)
    code_of._refuse_old(name, path, (2, 0, 0, 0))
    with pytest.raises(DataError, match=r"never_imported\.py: expected the program's code as it is loaded"):
        code_of._refuse_old(name, path, (3, 0, 0, 0))
