"""One process at a time uses a rig."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from emg2vsa.errors import DeviceError
from emg2vsa.lab.rig_lock import lock_path, rig_lock, rig_user
from emg2vsa.rig_file import RigFile


def test_the_lock_names_its_holder_and_goes_with_it(tmp_path: Path) -> None:
    path = tmp_path / "rig.toml"
    assert rig_user(path) is None
    with rig_lock(path, tmp_path / "run"):
        user = rig_user(path)
        assert user is not None
        assert (user.pid, user.folder) == (os.getpid(), tmp_path / "run")
    assert rig_user(path) is None


def test_a_link_to_a_rig_file_has_the_lock_of_the_file(file: RigFile, tmp_path: Path) -> None:
    path, link = file.path, tmp_path / "elsewhere" / "other.toml"
    link.parent.mkdir()
    link.symlink_to(path)
    with rig_lock(path):
        user = rig_user(link)
        assert (user is not None, lock_path(link)) == (True, lock_path(path))
        with pytest.raises(DeviceError, match="expected a rig that no other process uses"), rig_lock(link):
            pass
