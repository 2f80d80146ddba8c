"""Emulated devices and an emulated operator, served by `emg2vsa.session.emulate` for a session elsewhere."""

from __future__ import annotations

import json
import socket
import threading
from dataclasses import replace

import pytest

from benchmarks.small_study import SIMULATED_SESSION, small_study
from emg2vsa import session
from emg2vsa.devices.trigno import TrignoSettings
from emg2vsa.errors import DeviceError, SettingError
from emg2vsa.study_file import load_study


@pytest.fixture
def simulated(tmp_path):
    """A study whose devices are simulated within the process."""
    text = small_study(
        participants=["P03"], specimens=["S1"], task="press", tables=f"[session]\n{SIMULATED_SESSION}repetitions = 1\n"
    )
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    return load_study(tmp_path / "study.toml")


@pytest.fixture
def study(simulated):
    """The same with a Trigno server."""
    ports = []
    for _ in range(2):
        with socket.socket() as probe:
            probe.bind(("127.0.0.1", 0))
            ports.append(probe.getsockname()[1])
    emg = TrignoSettings(channels={"EDC": "1", "FDS": "5"}, command_port=ports[0], emg_port=ports[1])
    return replace(simulated, session=replace(simulated.session, emg=emg))


def test_devices_are_served_until_the_block_ends_and_the_truth_is_kept(study, tmp_path, capsys):
    virtual = session.Virtual(truth=tmp_path / "truth.json")
    with session.emulate(study, "P03", virtual=virtual) as table:
        emg = table.served.addresses["emg"]
        assert emg["ports"]["command"] == study.session.emg.command_port
        with socket.create_connection(("127.0.0.1", emg["ports"]["command"]), timeout=60) as line:
            assert line.recv(20).startswith(b"Delsys")
        table.place("S1")
        table.served.trigno.drop(2)
        with pytest.raises(DeviceError, match="a page of a running session"):
            table.follow("http://127.0.0.1:9/")
        assert table.obey("drop many") == "drop: expected a number, but found 'many'."
        assert not virtual.truth.exists()
    assert json.loads(virtual.truth.read_text())["participant"] == "P03"
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", emg["ports"]["command"]), timeout=60)
    assert capsys.readouterr().out == ""


@pytest.mark.parametrize(
    ("participant", "options", "said"),
    [
        ("P99", {}, "--participant P99: expected one of P03"),
        ("P03", {"start_delay_s": -1.0}, "--start-delay"),
        ("P03", {"virtual": session.Virtual(mistakes=("sneeze@1",))}, "--mistake"),
    ],
)
def test_what_cannot_be_emulated_is_refused(study, participant, options, said):
    with pytest.raises(SettingError, match=said), session.emulate(study, participant, **options):
        pass


def test_a_study_without_devices_is_refused(simulated):
    with pytest.raises(SettingError, match="simulated and simulated"), session.emulate(simulated, "P03"):
        pass


def test_an_emulated_operator_works_with_the_page_of_a_session(simulated, study):
    """The session goes on from the measurement at rest, which only an operator can ask for."""
    awaited, over = [], threading.Event()

    def operate(addresses):
        with session.emulate(study, "P03", operate=True) as table:
            table.follow_operator(addresses.operator)
            over.wait(60)

    def seen(state):
        awaited.append(state.awaits)
        if state.awaits == "contraction":
            raise KeyboardInterrupt

    helpers = []

    def shown(addresses):
        helpers.append(threading.Thread(target=operate, args=(addresses,), daemon=True))
        helpers[0].start()

    virtual = session.Virtual(speed=20.0)
    try:
        done = session.run(simulated, "P03", virtual=virtual, pages=session.Pages(port=0), shown=shown, seen=seen)
    finally:
        over.set()
    helpers[0].join()
    assert done.why == "Ctrl-C"
    assert awaited[0] == "quality"
    assert awaited[-1] == "contraction"
