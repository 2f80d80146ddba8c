"""What others get of a session: LSL streams beside its recordings, and triggers on a serial port."""

from __future__ import annotations

import csv
import os
import pty
import sys
import tty
from contextlib import suppress

import numpy as np
import pytest

from benchmarks.lsl_outlets import STREAMS, alone_on_this_computer, compared, read_xdf, recording, xdf_bytes
from emg2vsa.devices.clock import VirtualClock
from emg2vsa.devices.streams import StreamInfo
from emg2vsa.devices.trigger import TriggerOut
from emg2vsa.errors import DeviceError
from emg2vsa.session import plugs as plugging
from emg2vsa.session import replay
from emg2vsa.session.dataset import write_dataset
from emg2vsa.session.journal import JOURNAL_FILE, Commanded, Judged, PressEnded, Triggered, read_journal
from emg2vsa.session.plugs import Outlets
from emg2vsa.session.traces import ENVELOPE_S, LiveEnvelope
from emg2vsa.session_settings import TriggerSettings

FEW = "repetitions = 2\n"


@pytest.fixture(scope="module")
def lsl(tmp_path_factory):
    with pytest.MonkeyPatch.context() as patch:
        for name, value in alone_on_this_computer(tmp_path_factory.mktemp("lsl")).items():
            patch.setenv(name, value)
        yield pytest.importorskip("pylsl", reason="pylsl is not installed")


def lines_of(played, kind):
    return [line for line in read_journal(played.folder / JOURNAL_FILE)[0] if isinstance(line.event, kind)]


@pytest.mark.slow
def test_a_recorder_of_the_streams_has_the_samples_and_the_moments_of_the_recordings(lsl, play, tmp_path, monkeypatch):
    opened = plugging.Outlets
    heard = []

    class Recorded(opened):
        def __init__(self, *given):
            super().__init__(*given)
            heard.append(recording(lsl))
            heard.append(heard[0].__enter__())

    monkeypatch.setattr("emg2vsa.session.open_session.Outlets", Recorded)
    played = play("early@2", session=FEW + "lsl_outlets = true")
    heard[0].__exit__(None, None, None)
    recorded = heard[1]
    assert len(recorded) == STREAMS
    (tmp_path / "recorded.xdf").write_bytes(xdf_bytes(recorded))
    streams = read_xdf(tmp_path / "recorded.xdf")
    write_dataset(played.folder, played.study)
    same = list(compared(played.study.data, streams))
    assert len(same) == 3 * len(list(played.study.data.rglob("*_emg.bdf"))) > 0
    assert all(steps <= 0.501 for _, _, steps in same), same

    envelope = LiveEnvelope(1000.0).take(np.asarray(streams["EMG"][0], dtype=float))
    np.testing.assert_allclose(streams["envelopes"][0], envelope, rtol=1e-3, atol=1e-9)
    assert 1e-5 < envelope.max() < 1e-3

    texts = {name: list(zip((row[0] for row in streams[name][0]), streams[name][1], strict=True))
             for name in ("markers", "verdicts")}  # fmt: skip
    found = {"START": [], "STOP": [], "press-begun": [], "press-ended": [], "specimen": []}
    for text, time_s in texts["markers"]:
        found[text.split()[0]].append(time_s)
    ended = lines_of(played, PressEnded)
    stops = [line.time_s for line in lines_of(played, Commanded) if line.event.command == "stop"]
    offset_s = found["STOP"][0] - stops[0]
    np.testing.assert_allclose(found["STOP"], np.array(stops) + offset_s, atol=2e-6)
    np.testing.assert_allclose(found["press-begun"], [e.event.start_s + offset_s for e in ended], atol=2e-6)
    np.testing.assert_allclose(found["press-ended"], [e.event.stop_s + offset_s for e in ended], atol=2e-6)
    assert len(found["specimen"]) == 2
    said = [text for text, _ in texts["verdicts"]]
    judged = [line.event for line in lines_of(played, Judged)]
    assert [text.split()[:3] for text in said] == [
        [e.verdict, f"press={e.press}", f"attempt={e.attempt}"] for e in judged
    ]
    assert {text.split()[3] for text in said} == {"specimen=S1", "specimen=S3"}
    for name in ("EMG", "force"):
        gaps_s = np.diff(streams[name][1])
        assert np.abs(gaps_s - 0.001).max() < 1e-3
        assert abs(np.median(gaps_s) - 0.001) < 1e-6


def test_a_stream_says_what_its_channels_are_and_is_found_again_by_its_id(lsl):
    emg = StreamInfo("emg", ("EDC", "FDS"), "V", 2000.0)
    ids = []
    for _ in range(2):
        outlets = Outlets("of plugs", emg.channels, emg, StreamInfo("force", ("force",), "N", 500.0), VirtualClock())
        own = {}
        while len(own) < STREAMS:
            own = {each.name(): each for each in lsl.resolve_streams(1.0) if "-of plugs-" in each.source_id()}
        ids.append({name: each.source_id() for name, each in own.items()})
        said = {name: lsl.StreamInlet(each).info(5.0) for name, each in own.items()}
        del outlets
    assert ids[0] == ids[1]
    kinds = {name: (info.type(), info.nominal_srate(), _channels(info)) for name, info in said.items()}
    assert kinds == {
        "emg2vsa EMG": ("EMG", 2000.0, [("EDC", "V", "EMG"), ("FDS", "V", "EMG")]),
        "emg2vsa envelopes": ("Envelope", 2000.0, [("EDC", "V", "Envelope"), ("FDS", "V", "Envelope")]),
        "emg2vsa force": ("Force", 500.0, [("force", "N", "Force")]),
        "emg2vsa markers": ("Markers", 0.0, [("marker", "", "Markers")]),
        "emg2vsa verdicts": ("Markers", 0.0, [("verdict", "", "Markers")]),
    }


def _channels(info):
    channel, found = info.desc().child("channels").child("channel"), []
    while not channel.empty():
        found.append(tuple(channel.child_value(key) for key in ("label", "unit", "type")))
        channel = channel.next_sibling()
    return found


@pytest.mark.slow
def test_a_fault_of_lsl_is_told_and_the_session_goes_on(lsl, play, monkeypatch):
    samples = Outlets.samples

    def fails(self, name, values, newest_s):
        if newest_s > 20.0:
            raise lsl.util.InternalError("the network is gone")
        samples(self, name, values, newest_s)

    monkeypatch.setattr(Outlets, "samples", fails)
    played = play(session=FEW + "lsl_outlets = true")
    assert played.state.ended == "completed"
    said = "The LSL streams have ended (the network is gone). The session goes on without them."
    assert [text for text in played.state.warnings if "LSL" in text] == [said]


def test_without_pylsl_a_session_with_outlets_does_not_begin(play, monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "pylsl", None)
    with pytest.raises(DeviceError, match=r'session\.lsl_outlets: expected the extra for LSL, .*"\.\[lsl\]"'):
        play(session=FEW + "lsl_outlets = true")
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("pieces", [1, 7, 400])
def test_an_envelope_is_the_same_in_whatever_pieces_it_comes_and_passes_over_what_is_lost(pieces):
    fs_hz = 1000.0
    samples = np.random.default_rng(1).normal(3e-3, 1e-4, (4000, 2))
    lost = samples.copy()
    lost[1000:1100, 1] = np.nan
    own, whole = LiveEnvelope(fs_hz), LiveEnvelope(fs_hz).take(np.delete(samples, slice(1000, 1100), axis=0))
    envelope = np.concatenate([own.take(part) for part in np.array_split(lost, pieces)])
    assert np.isnan(envelope[1000:1100]).all()
    np.testing.assert_allclose(np.delete(envelope, slice(1000, 1100), axis=0), whole, rtol=1e-9)
    level = 1e-4 * np.sqrt(2 / np.pi)  # mean of a rectified normal
    assert whole[round(5 * ENVELOPE_S * fs_hz) :].mean() == pytest.approx(level, rel=0.1)


class Port:
    """A pseudo-terminal that somebody listens to. name : of the end that is opened."""

    def __init__(self):
        self._far, self._near = pty.openpty()
        tty.setraw(self._near)
        os.set_blocking(self._far, False)
        self.name = os.ttyname(self._near)

    def heard(self):
        try:
            return os.read(self._far, 1 << 16)
        except BlockingIOError:
            return b""

    def pull(self):
        for end in (self._far, self._near):
            with suppress(OSError):
                os.close(end)


@pytest.fixture
def port():
    port = Port()
    yield port
    port.pull()


@pytest.mark.slow
def test_start_stop_and_verdicts_are_bytes_on_the_port_and_marks_in_journal_and_events(play, port):
    played = play(session=FEW + f'trigger = {{ port = "{port.name}", verdict = 9 }}')
    marks = lines_of(played, Triggered)
    written = port.heard()
    assert written[0] == 0  # at rest
    assert [each for each in written if each] == [line.event.code for line in marks]
    assert written.count(0) == len(marks) + 1
    commands = [
        line for line in lines_of(played, Commanded) if line.event.press and line.event.command in ("start", "stop")
    ]
    own = [line for line in marks if line.event.mark != "verdict"]
    assert [(line.event.mark, line.event.press, line.event.attempt) for line in own] == [
        (line.event.command, line.event.press, line.event.attempt) for line in commands
    ]
    np.testing.assert_allclose([line.time_s for line in own], [line.time_s for line in commands], atol=1e-3)
    judged = [(line.event.press, line.event.attempt) for line in lines_of(played, Judged)]
    assert [(line.event.press, line.event.attempt) for line in marks if line.event.mark == "verdict"] == judged
    assert {line.event.code for line in marks} == {1, 2, 9}

    assert replay(played.study, played.folder).same
    write_dataset(played.folder, played.study)
    (events, *_) = sorted(played.study.data.rglob("*acq-S1*_events.tsv"))
    rows = list(csv.DictReader(events.open(), delimiter="\t"))
    triggers = [row for row in rows if row["trial_type"] == "trigger"]
    assert {row["value"] for row in rows if row["trial_type"] != "trigger"} == {"n/a"}
    assert {row["value"] for row in triggers} == {"1", "2", "9"}
    starts = {row["onset"] for row in rows if row["trial_type"] == "command_start"}
    pressed = {row["press"] for row in rows if row["trial_type"] == "press"}
    assert {row["press"] for row in triggers if row["value"] == "9"} == pressed
    assert {row["onset"] for row in triggers if row["value"] == "1"} == starts != set()


@pytest.mark.slow
def test_a_port_that_is_gone_is_told_and_the_session_goes_on(play, port):
    def pull(desk, now_s):
        if now_s > 30.0:
            port.pull()

    played = play(session=FEW + f'trigger = {{ port = "{port.name}" }}', beside=pull)
    assert played.state.ended == "completed"
    (said,) = (text for text in played.state.warnings if "trigger" in text)
    assert said.startswith(f"session.trigger.port, {port.name}: expected a serial port that takes a byte, but found ")
    assert said.endswith("Check the cable. The session goes on without triggers.")
    assert 0 < len(lines_of(played, Triggered)) < 12


@pytest.mark.parametrize(
    ("settings", "found"),
    [
        ({"port": "/dev/no-such-port"}, "no-such-port"),
        ({"pulse": "dtr"}, "[Ii]nappropriate ioctl"),  # a pseudo-terminal has no such line
    ],
)
def test_a_port_that_takes_no_trigger_is_one_error_before_the_session(settings, found, port, play, tmp_path):
    own = {"port": port.name} | settings
    text = ", ".join(f'{key} = "{value}"' for key, value in own.items())
    with pytest.raises(DeviceError, match=rf"session\.trigger\.port, {own['port']}: expected a serial port .*{found}"):
        play(session=FEW + f"trigger = {{ {text} }}")
    assert not (tmp_path / "data").exists()


@pytest.mark.parametrize("pulse", ["byte", "dtr", "rts"])
def test_a_pulse_ends_when_its_time_has_come(monkeypatch, pulse):
    done = []

    class Line:
        def __init__(self, port, baud):
            assert (port, baud) == ("COM3", 9600)

        def write(self, data):
            done.append(data[0])

        def set_control(self, line, high):
            assert line == pulse
            done.append(int(high))

        def close(self):
            done.append("closed")

    monkeypatch.setattr("emg2vsa.devices.trigger.SerialLine", Line)
    clock = VirtualClock()
    trigger = TriggerOut(TriggerSettings(port="COM3", pulse=pulse, baud=9600, pulse_s=0.02, stop=7), clock)
    clock.sleep_until(3.0)
    code = 7 if pulse == "byte" else 1
    assert trigger.send("stop") == (code, 3.0)
    trigger.turn(3.019)
    assert done == [0, code]
    trigger.turn(3.02)
    trigger.turn(3.03)
    assert done == [0, code, 0]
    trigger.send("start")
    trigger.close()
    assert done == [0, code, 0, 1, 0, "closed"]
