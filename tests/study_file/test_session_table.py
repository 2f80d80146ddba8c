"""The table [session]: what it contradicts, and at which key that is said."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.study import Study

NI = """
[session.emg]
kind = "ni-daq"
channels = { EDC = "Dev1/ai0", FDS = "Dev1/ai1" }
gain = 1000
[session.force]
kind = "rig"
rig = "rig.toml"
"""
SIMULATED = '\n[session]\nemg.kind = "simulated"\nforce.kind = "simulated"\n'
PLACES = 'places = { system = "x from the elbow, y across", '
BOTH = "EDC = [[0, 0], [10, 0]], FDS = [[0, 5], [10, 5]]"
CASES = [
    # sources
    ('emg.kind = "simulated"', "", "session.emg", "nothing"),
    ('"simulated"', '"bluetooth"', "session.emg.kind", "'ni-daq', 'trigno', 'lsl' or 'simulated'"),
    ('emg.kind = "simulated"', 'emg.kind = "ni-daq"', "session.emg.channels", "a key 'channels' with kind = 'ni-daq'"),
    ("+", "emg.gain = 10", "session.emg.gain", "'gain' is of 'ni-daq'"),
    ("+", 'emg.host = "10.0.0.1"', "session.emg.host", "keys of this kind only"),
    ("+", 'emg.stream = "x"', "session.emg.stream", "keys of this kind only"),
    ("+", 'force.rig = "rig.toml"', "session.force.rig", "keys of this kind only"),
    ("+", 'force.channel = "x"', "session.force.channel", "keys of this kind only"),
    ("+", "emg.delay_s = 48", "session.emg.delay_s", "<= 1"),
    ("+", "bar_filter_hz = 0.5", "session.bar_filter_hz", ">= 1"),
    ("+", "bar_n = 51", "session.bar_n", "<= 50"),
    ("+", "most_repeats = 1001", "session.most_repeats", "<= 1000"),
    ("+", "force_n = [0.5, 60]\nlimits.peak_n = 90", "session.force_n[1]", "at most 50 N"),
    ("+", "limits.early_s = 1.5", "session.limits.early_s", "less than the time of a reaction"),
    ("+", 'texts.start = "Go"\ntexts.stop = "go"', "session.texts.stop", "another text than that of start"),
    ("+", "checklist = []\ncheck_each_press = true", "session.checklist", "an item with check_each_press"),
    ("+", "emg.delay_s = -1", "session.emg.delay_s", ">= 0"),
    # forces and times
    ("+", "force_n = [7, 0.5]", "session.force_n", "the smaller number first"),
    ("+", "force_n = [0.5, 6]", "session.force_n", "[window] force_n = [0.5, 7.0]"),
    ("+", "force_n = [0.6, 7]", "session.force_n", "at least the range that is analysed"),
    ("+", "bar_n = 5", "session.bar_n", "at least the upper force, 7"),
    ("+", "ready_n = 0.5", "session.ready_n", "less than the lower force, 0.5"),
    ("+", "limits.peak_n = 7", "session.limits.peak_n", "more than the upper force"),
    ("+", "limits.reaction_s = [5, 2]", "session.limits.reaction_s", "the smaller number first"),
    ("+", "limits.zero_n = [0.5, 0.2]", "session.limits.zero_n", "the smaller number first"),
    ("+", "limits.lost_share = [0.5, 0.2]", "session.limits.lost_share", "the smaller number first"),
    ("+", "load_s = [5, 1]", "session.load_s", "the smaller number first"),
    ("+", "load_s = [0.2, 5]", "session.load_s", "[window] accepts, 0.5 to 20"),
    ("+", "load_s = [1, 30]", "session.load_s", "right on the screen and rejected"),
    ("+", "rest_s = -1", "session.rest_s", ">= 0"),
    # order and counts
    ("+", 'order = "random"', "session.order", "'blocked', 'interleaved', 'listed', 'latin-square' or 'williams'"),
    ("+", 'orders = { P01 = ["S1"] }', "session.orders", "Set order = 'listed'"),
    ("+", 'order = "listed"\norders = { P01 = ["S1", "S1", "S3"] }', "session.orders.P01", "every specimen once"),
    ("+", 'order = "listed"\norders = { P1 = ["S1"] }', "session.orders.P1", "Did you mean 'P01'?"),
    ("+", 'order = "listed"\norders = { P01 = ["S1"] }', "session.orders", "none for P02"),
    ("+", "seed = -1", "session.seed", ">= 0"),
    ("+", "repetitions = 0", "session.repetitions", ">= 1"),
    ("+", 'stop = "width"\nmost_presses = 5', "session.most_presses", "at least repetitions = 10"),
    ("+", "most_presses = 30", "session.most_presses", "stop = 'width' with this key"),
    ("+", "width = 0.1", "session.width", 'Set stop = "width"'),
    ("+", 'stop = "significance"', "session.stop", "'count' or 'width'"),
    ("+", "[window]\nexpected_trials = 8", "session.repetitions", "expected_trials, 8"),
    ("+", 'training_specimens = ["T1", "s3"]', "session.training_specimens[1]", "not among [[specimens]]"),
    ("+", 'training_specimens = ["T1", "T1"]', "session.training_specimens[1]", "'T1' again"),
    ("+", 'training_specimens = ["T_1"]', "session.training_specimens[0]", "letters and digits only"),
    # plugs
    ("+", 'lsl_outlets = "yes"', "session.lsl_outlets", "true or false"),
    ("+", "trigger.start = 3", "session.trigger.port", "a key 'port'"),
    ("+", 'trigger = { port = "" }', "session.trigger.port", "not empty"),
    ("+", 'trigger = { port = "COM3", stop = 256 }', "session.trigger.stop", "<= 255"),
    ("+", 'trigger = { port = "COM3", pulse = "ttl" }', "session.trigger.pulse", "'byte', 'dtr' or 'rts'"),
    ("+", 'trigger = { port = "COM3", pulse = "rts", pulse_s = 0 }', "session.trigger.pulse_s", "more than 0"),
    ("+", 'trigger = { port = "COM3", end = 3 }', "session.trigger.end", "a known key"),
    ("+", 'palette = "red"', "session.palette", "'paper' or 'safe'"),
    ("+", "texts.start = ''", "session.texts.start", "not empty"),
    ("+", "texts.begin = 'Los'", "session.texts.begin", "a known key"),
    ("+", "repetition = 5", "session.repetition", "Did you mean 'repetitions'?"),
    # the form of a participant
    ("+", 'form.surname = { description = "x", range = [1, 2] }', "session.form.surname", "does not say who somebody"),
    ("+", 'form.Age = { description = "x", range = [1, 2] }', "session.form.Age", "a name of small letters"),
    ("+", 'form.age = { description = "x" }', "session.form.age", "either range or levels, but found neither"),
    ("+", 'form.age = { description = "x", range = [2, 1] }', "session.form.age.range", "the smaller number first"),
    (
        "+",
        'form.sex = { description = "x", levels.F = "f", unit = "m" }',
        "session.form.sex.unit",
        "range with this key",
    ),
    ("+", "form.age = { range = [1, 2] }", "session.form.age.description", "a key 'description'"),
    ("+", 'form.sex = { description = "x", levels."=1" = "f" }', "session.form.sex.levels.=1", "a word without tab"),
    ("+", 'form.sex = { description = "x", levels."n/a" = "f" }', "session.form.sex.levels.n/a", "a word without tab"),
    ("+", 'trigger = { port = "COM3", start = 2 }', "session.trigger.stop", "another byte than that of start"),
    ("+", 'trigger = { port = "COM3", pulse = "dtr", start = 3 }', "session.trigger.start", "pulse = 'byte' with this"),
    ("+", "about.band_hz = [450, 20]", "session.about.band_hz", "the smaller number first"),
    (
        "+",
        f"{PLACES}pairs = {{ EDC = [[0, 0], [1, 0]], FDS = [[0, 0], [2, 0]] }} }}",
        "session.places.pairs",
        "of its own",
    ),
    (
        "+",
        f'{PLACES}unit = "percent", pairs = {{ EDC = [[0, 0], [500, 0]], FDS = [[1, 0], [2, 0]] }} }}',
        "session.places.pairs",
        "0 to 100 with unit",
    ),
    # places of electrodes
    ("+", f"{PLACES}pairs = {{ EDC = [[0, 0], [10, 0]] }} }}", "session.places.pairs.FDS", "two electrodes of each"),
    ("+", f"{PLACES}pairs = {{ {BOTH}, X = [[0, 0], [1, 0]] }} }}", "session.places.pairs.X", "and of no other"),
    (
        "+",
        f"about.electrode_mm = 20\n{PLACES}pairs = {{ {BOTH} }} }}",
        "session.places.pairs.EDC",
        "20 mm apart, but found 10",
    ),
    ("+", f"{PLACES}pairs = {{ EDC = [[0, 0]] }} }}", "session.places.pairs.EDC[1]", "one more entry"),
    # where and how it is written
    ('task = "press"', 'task = "press"\nvisits = ["1", "1"]', "recordings.visits[1]", "every name once"),
    ('task = "press"', 'task = "press"\nvisits = ["ses-1"]', "recordings.visits[0]", "letters and digits only"),
    ('layout = "bids"', 'layout = "files"\nvisits = ["1"]', "recordings.visits", "keys of this layout only"),
    ('ids = ["P01", "P02"]', 'ids = ["P01", "Maria"]', "participants", "codes with [session]"),
    ('task = "press"', 'task = "training"', "recordings.task", "another name than that of the practice"),
    ('task = "press"', 'task = "press"\nextension = "edf"', "recordings.extension", "'bdf' with [session]"),
    ("BIDS", "PATTERN", "session", "layout = 'pattern'"),
    ('name = "EMG 1"', 'name = "EMG 1"\ngain = 1000', "channels.emg.EDC.gain", "amplifier's gain in [session.emg]"),
    ('name = "EMG 1"', 'name = "EMG 1"\nunit = "mV"', "channels.emg.EDC.unit", "'uV'"),
    ('name = "EMG 1"', 'name = "the first EMG channel"', "channels.emg.EDC.name", "at most 16 ASCII"),
    ('name = "Fz"', 'name = "Fz"\nunit = "lbf"', "channels.force.unit", "'N'"),
    ('name = "Fz"', 'name = "Fz"\nnewtons_per_unit = 2', "channels.force.newtons_per_unit", "no such key"),
    ('name = "Fz"', 'name = "Fz"\ndelay_s = 0.1', "channels.force.delay_s", "delay in [session.force]"),
]
OF_CARD = 'kind = "ni-daq"\nchannels = { EDC = "Dev1/ai0", FDS = "Dev1/ai1" }\ngain = 1000'
OF_TRIGNO = 'kind = "trigno"\nchannels = { EDC = "1", FDS = "2" }'
OF_NI = [
    ('EDC = "Dev1/ai0", ', "", "session.emg.channels.EDC", "channel of the muscle 'EDC'"),
    ('"Dev1/ai1"', '"Dev1/ai0"', "session.emg.channels.FDS", "as for EDC"),
    ("EDC =", "ECD =", "session.emg.channels.ECD", "Did you mean 'EDC'?"),
    ('"Dev1/ai1"', '"1"', "session.emg.channels.FDS", "'Dev1/ai0'"),
    ('"ni-daq"', '"trigno"', "session.emg.channels.EDC", "'1' to '16'"),
    ("gain = 1000", "gain = 0", "session.emg.gain", ">= 0.1"),
    ("gain = 1000", "fs_hz = 100", "session.emg.fs_hz", ">= 200"),
    ("gain = 1000", "range_v = 1e6", "session.emg.range_v", "<= 100"),
    ('"Dev1/ai1"', '"Dev1/ai00"', "session.emg.channels.FDS", "as for EDC"),
    (OF_CARD, f"{OF_TRIGNO}\ncommand_port = 50043", "session.emg.emg_port", "another port"),
    (OF_CARD, f"{OF_TRIGNO}\ncommand_port = 70000", "session.emg.command_port", "<= 65535"),
    (OF_CARD, f"{OF_TRIGNO}\nemg_port = 50041", "session.emg.emg_port", "no legacy"),
    (OF_CARD, OF_TRIGNO.replace('"2"', '"1.1"'), "session.emg.channels.FDS", "as for EDC"),
    ('rig = "rig.toml"', "", "session.force.rig", "a key 'rig'"),
    ('rig = "rig.toml"', 'rig = "rig.toml"\naxis = [0, 0, 0]', "session.force.axis", "a direction"),
    ('kind = "rig"', 'kind = "rig"\nstream = "x"', "session.force.stream", "keys of this kind only"),
]
PATTERN = 'layout = "pattern"\npattern = "data/{participant}_{specimen}.csv"'
BIDS = 'layout = "bids"\nroot = "data"\ntask = "press"'


def changed(text: str, old: str, new: str) -> str:
    if old == "+":
        return text + new + "\n"
    if old == "BIDS":
        old, new = BIDS, PATTERN
    assert old in text
    return text.replace(old, new, 1)


@pytest.fixture
def with_session(small: str) -> Callable[[str], str]:
    return lambda table: small.replace(PATTERN, BIDS) + table


@pytest.mark.parametrize(("old", "new", "key", "said"), CASES)
def test_what_a_session_contradicts_is_said_at_its_key(load, with_session, old, new, key, said):
    with pytest.raises(StudyError) as caught:
        load(changed(with_session(SIMULATED), old, new))
    assert any(f" {key}: " in problem and said in problem for problem in caught.value.problems), str(caught.value)


@pytest.mark.parametrize(("old", "new", "key", "said"), OF_NI)
def test_channels_of_a_device(load, with_session, old, new, key, said):
    with pytest.raises(StudyError) as caught:
        load(changed(with_session("\n[session]\n" + NI), old, new))
    assert any(f" {key}: " in problem and said in problem for problem in caught.value.problems), str(caught.value)


def test_a_session_without_fault(load: Callable[[str], Study], with_session):
    text = with_session('\n[session]\ntraining_specimens = ["T1"]\nstop = "width"\nmost_presses = 15\n' + NI)
    session = load(text).session
    assert session is not None
    assert session.emg.channels == {"EDC": "Dev1/ai0", "FDS": "Dev1/ai1"}
    assert session.force.axis == (0.0, 0.0, -1.0)
    assert load(with_session("")).session is None


def test_a_session_on_streams_of_lsl(load: Callable[[str], Study], with_session):
    text = with_session('\n[session]\nemg.kind = "lsl"\nemg.channels = { EDC = "1", FDS = "2" }\nforce.kind = "lsl"\n')
    session = load(text).session
    assert session is not None
    assert (session.emg.kind, session.force.kind) == ("lsl", "lsl")


def test_a_session_needs_recordings_and_channels(load):
    runs = '[study]\nname = "r"\n[[specimens]]\nname = "S1"\nstiffness_n_per_mm = 3\n[runs]\n'
    with pytest.raises(StudyError) as caught:
        load(runs + SIMULATED)
    assert "a table [recordings] with layout = 'bids'" in str(caught.value)
    assert "tables [channels.emg.<muscle>]" in str(caught.value)
