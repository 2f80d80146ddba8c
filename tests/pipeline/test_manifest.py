from __future__ import annotations

import shutil
from pathlib import Path

from emg2vsa.pipeline.manifest import manifest_files, manifest_holds, write_manifest


def wrote(project: Path, names: str, key: str) -> Path:
    """A step's run that wrote these files; its manifest."""
    files = [project / "reports" / name for name in names]
    for file in files:
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(file.name)
    path = project / "store" / "report" / f"{key}.result"
    write_manifest(path, files)
    return path


def test_a_manifest_holds_while_its_files_are_as_long_as_they_were(tmp_path):
    path = wrote(tmp_path, "ab", "1")
    assert manifest_files(path) == [tmp_path / "reports" / name for name in "ab"]
    assert manifest_holds(path)
    (tmp_path / "reports" / "a").write_text("longer")
    assert not manifest_holds(path)


def test_what_only_an_earlier_run_wrote_goes(tmp_path):
    wrote(tmp_path, "ab", "1")
    wrote(tmp_path, "bc", "2")
    assert sorted(path.name for path in (tmp_path / "reports").iterdir()) == ["b", "c"]


def test_the_copy_of_a_project_leaves_the_files_of_the_original_alone(tmp_path):
    wrote(tmp_path / "original", "ab", "1")
    shutil.copytree(tmp_path / "original", tmp_path / "copy")
    again = wrote(tmp_path / "copy", "bc", "2")
    assert manifest_files(again) == [tmp_path / "copy" / "reports" / name for name in "bc"]
    assert sorted(path.name for path in (tmp_path / "original" / "reports").iterdir()) == ["a", "b"]
    assert sorted(path.name for path in (tmp_path / "copy" / "reports").iterdir()) == ["b", "c"]
