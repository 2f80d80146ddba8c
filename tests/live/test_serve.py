"""The server as a process of its own, and the command that starts it."""

from __future__ import annotations

import http.client
import shutil
import signal
import socket
import subprocess
import sys
from contextlib import contextmanager
from pathlib import Path
from urllib.parse import urlsplit

import pytest

import emg2vsa.live
from emg2vsa.cli import main
from emg2vsa.errors import SettingError
from emg2vsa.live.server import listening, serve

STUDIES = Path(__file__).resolve().parents[2] / "studies" / "palpation"


@contextmanager
def started(command):
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as server:
        try:
            yield server
        finally:
            server.kill()


@pytest.fixture
def taken():
    with socket.socket() as other:
        other.bind(("127.0.0.1", 0))
        other.listen()
        yield other.getsockname()[1]


def test_a_page_is_watched_and_ctrl_c_ends_it_while_somebody_looks(begin, row, runs):
    begin("run").row(row(0.005))
    command = [sys.executable, "-m", "emg2vsa.cli", "rig", "watch", str(runs), "--port", "0"]
    with started(command) as server:
        lines = [server.stdout.readline() for _ in range(3)]
        address = urlsplit(lines[1].split()[1])
        page = http.client.HTTPConnection(address.netloc, timeout=120)
        page.request("GET", f"{address.path}stream")
        answer = page.getresponse()
        told = [answer.readline() for _ in range(3)]
        server.send_signal(signal.SIGINT)
        _, complaints = server.communicate(timeout=120)
    assert lines[0] == f"Watching {runs}\n"
    assert address.hostname == "127.0.0.1"
    assert len(address.path.split("/")[1]) >= 20
    assert answer.getheader("content-type").startswith("text/event-stream")
    assert b'"time_s":[0.005]' in told[2]
    assert (server.returncode, complaints) == (0, "")


def test_every_start_has_a_token_of_its_own(monkeypatch):
    monkeypatch.setattr("emg2vsa.live.server.uvicorn.Server.run", lambda server, sockets: None)
    addresses = []
    for _ in range(2):
        with listening(0) as at:
            serve({"watch": []}, at, addresses.append)
    tokens = {urlsplit(address).path.split("/")[1] for address in addresses}
    assert len(tokens) == 2


def test_only_this_computer_is_served():
    with listening(0) as at:
        assert [own.getsockname()[0] for own in at.sockets] == ["127.0.0.1"]


def test_a_port_that_is_taken(taken):
    with (
        pytest.raises(
            SettingError, match=f"port {taken}: expected a free port, but found .+ Choose another port with --port"
        ),
        listening(taken),
    ):
        pass


def without(library, monkeypatch):
    """Pages are imported anew, whoever did so before, and find no such library."""
    monkeypatch.setattr("emg2vsa.live", emg2vsa.live)  # the package of before comes back for the other tests
    for name in [name for name in sys.modules if name.startswith((library, "emg2vsa.live"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, library, None)


@pytest.mark.parametrize("library", ["starlette", "uvicorn"])
def test_without_the_extra_the_command_says_what_to_install(tmp_path, capsys, monkeypatch, library):
    without(library, monkeypatch)
    assert main(["rig", "watch", str(tmp_path)]) == 2
    said = capsys.readouterr().err
    assert f"found no {library}" in said
    assert 'pip install ".[web]"' in said
    assert said.count("\n") == 1


def test_a_file_is_no_folder(tmp_path, capsys):
    (tmp_path / "log.csv").write_text("")
    assert main(["rig", "watch", str(tmp_path / "log.csv")]) == 2
    assert "expected a folder, but found a file" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["-1", "65536", "http"])
def test_a_port_that_is_none(tmp_path, capsys, port):
    with pytest.raises(SystemExit):
        main(["rig", "watch", str(tmp_path), f"--port={port}"])
    assert "expected a port from 0 to 65535" in capsys.readouterr().err


@pytest.fixture
def session(tmp_path):
    """Words of a session that an emulated participant would do, and the folder that it would make."""
    for name in ("study.toml", "rig.toml"):
        shutil.copy(STUDIES / name, tmp_path)
    return ["session", str(tmp_path / "study.toml"), "--participant", "P03", "--virtual"], tmp_path / "data"


def test_a_session_begins_nothing_where_its_port_is_taken(session, taken, capsys):
    words, folder = session
    assert main([*words, "--port", str(taken)]) == 2
    assert f"port {taken}: expected a free port" in capsys.readouterr().err
    assert not folder.exists()


@pytest.mark.parametrize("address", ["0.0.0.0", "192.0.2.7", "tablet"])
def test_a_session_begins_nothing_with_an_address_that_is_none(session, address, capsys):
    words, folder = session
    assert main([*words, "--port", "0", "--bind", address]) == 2
    assert "--bind" in capsys.readouterr().err
    assert not folder.exists()


def test_a_session_begins_nothing_without_the_extra(session, capsys, monkeypatch):
    words, folder = session
    without("uvicorn", monkeypatch)
    assert main(words) == 2
    assert 'pip install ".[web]"' in capsys.readouterr().err
    assert not folder.exists()
