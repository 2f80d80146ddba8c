"""What is said of bad rig files, word for word."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import fields
from pathlib import Path

import pytest

from emg2vsa.errors import StudyError
from emg2vsa.rig.rig_settings import GuardSettings
from emg2vsa.rig_file import load_rig

Problems = Callable[[str], list[str]]
MOTOR = '[motor]\nport = "/dev/ttyUSB1"\n'
FORCE = '[force]\nkind = "net-ft"\nhost = "192.168.1.1"\n'


BAD: dict[tuple[str, str], list[str]] = {
    ("[actuator]", "[actuatr]"): [
        "1: actuatr: expected a known key, but found 'actuatr'. Did you mean 'actuator'?",
        "1: actuator: expected a table [actuator], but found nothing.",
    ],
    ('port = "/dev/ttyUSB0"', "baud = 9600"): ["2: actuator.baud: expected 2000000 or 460800, but found 9600."],
    ('port = "/dev/ttyUSB0"', 'port = 3\nid = 0\nwatchdog_s = 9\ngeneration = "v7.1"'): [
        "2: actuator.port: expected text in quotes, but found 3.",
        "3: actuator.id: expected a number >= 1, but found 0.",
        "4: actuator.watchdog_s: expected a number <= 5, but found 9.",
        "5: actuator.generation: expected 'v6' or 'v7', but found \"v7.1\". Did you mean 'v7'?",
    ],
    ('kind = "net-ft"', 'kind = "netft"'): [
        "8: force.kind: expected 'net-ft' or 'ni-daq', but found \"netft\". Did you mean 'net-ft'?",
    ],
    ('kind = "net-ft"', 'kind = "ni-daq"\ncal_file = "a.cal"'): [
        "7: force.channels: expected a key 'channels' with kind = 'ni-daq', but found nothing.",
        "10: force.host: expected keys of this kind only ('host' is of 'net-ft'), but found 'host' with kind = "
        "'ni-daq'.",
    ],
    ("[experiment]", '[experiment]\norder = "shuffled"\nseed = -1\nlead_s = 0.2'): [
        "12: experiment.order: expected 'random' or 'listed', but found \"shuffled\".",
        "13: experiment.seed: expected a number >= 0, but found -1.",
        "14: experiment.lead_s: expected a number <= 0.1, but found 0.2.",
    ],
    (FORCE, FORCE + "rate_hz = 1000\n"): [
        "10: force.rate_hz: expected a known key, but found 'rate_hz'. The keys are kind, serial_number, bias, host, "
        "rdt_port, http_port, buffered. [rig] has a key of that name.",
    ],
    ('["S1", "S3"]', '["S1", "S1", "S 3"]'): [
        "12: experiment.specimens[1]: expected every name once, but found 'S1' again.",
        "12: experiment.specimens[2]: expected letters, digits, - _ and dots only, the first a letter or digit, but "
        'found "S 3".',
        "14: emulated.stiffness_n_per_mm.S 3: expected the stiffness of every specimen, S 3 too, but found nothing. "
        "Did you mean 'S3'?",
    ],
    ('["S1", "S3"]', "[]"): ["12: experiment.specimens: expected at least 1 entry, but found []."],
    ('["S1", "S3"]', '["S1"]\nangles_deg = { modullar = [0] }'): [
        "13: experiment.angles_deg.modullar: expected 'high-stiffness', 'modular', 'constant-min', 'constant-mean' "
        "or 'constant-max', but found \"modullar\". Did you mean 'modular'?",
    ],
    ('["S1", "S3"]', '["S1"]\nangles_deg = { constant-min = [0, 90, 0] }'): [
        "13: experiment.angles_deg.constant-min[1]: expected 0 to below 90 degrees, but found 90.",
        "13: experiment.angles_deg.constant-min[2]: expected every angle once, but found 0 again.",
    ],
    ('["S1", "S3"]', '["S1"]\nangles_deg = { modular = [] }'): [
        "13: experiment.angles_deg: expected an angle of one condition at least, but found none.",
    ],
    ('["S1", "S3"]', '["S1"]\nf_max_n = 12\ntravel_mm = 20\nrepetitions = 2.5\nmountings = 0'): [
        "13: experiment.f_max_n: expected a force above contact, 0.5 N, and below the guard rig.guards.force_n, 10 "
        "N, but found 12.",
        "14: experiment.travel_mm: expected at most rig.travel_mm, 15, but found 20.",
        "15: experiment.repetitions: expected a whole number, but found 2.5.",
        "16: experiment.mountings: expected a number >= 1, but found 0.",
    ],
    ("[emulated]", '[emulated]\ncontrol = "N1"\nsensor_relaxation = 0.2\ncontrol_exponent = 0.1'): [
        '16: emulated.sensor_relaxation: expected no sensor_relaxation beside control = "N1", which sets it, but '
        "found 0.2. Leave it out, or choose another control.",
        '17: emulated.control_exponent: expected control = "P1" beside it, but found 0.1. Leave it out, or set the '
        "control.",
    ],
    ("[emulated]", '[emulated]\ncontrol = "P4"'): [
        "14: emulated.control_specimen: expected a specimen of the bench (S1, S2, S3, S4, S5) beside control = "
        '"P4", but found "". Name the specimen whose modular schedule is right.',
    ],
    ("[emulated]", '[emulated]\ncontrol = "N4"'): [
        "15: emulated.control: expected 'none', 'N1', 'N2', 'N3', 'P1', 'P2', 'P3' or 'P4', but found \"N4\". Did "
        "you mean 'P4'?",
    ],
    ('["S1", "S3"]', '["S1", "S3"]\nschedule_of = { S1 = "S3", S2 = "S1" }'): [
        "13: experiment.schedule_of.S2: expected a specimen of the experiment, but found \"S2\". Did you mean 'S3'?",
    ],
    ("[emulated]", "[emulated]\nforce_rate_hz = 1234.5\ngap_mm = 50\npreset_latency_s = 0.01"): [
        "15: emulated.force_rate_hz: expected a whole fraction of 7000, as 1400, but found 1234.5.",
        "16: emulated.gap_mm: expected contact within rig.guards.contact_mm, 6 mm, but found it after up to 50.2 mm "
        "(gap_mm and 2 gap_sd_mm). Choose a smaller gap, or a later guard.",
    ],
    ("[emulated]", "[emulated]\nseed = 4294967296\npreset_latency_s = 0.03\nsensor_relaxation = 0.78"): [
        "15: emulated.seed: expected a number <= 4294967295, but found 4294967296.",
        "16: emulated.preset_latency_s: expected a number <= 0.02, but found 0.03.",
        "17: emulated.sensor_relaxation: expected a number <= 0.75, but found 0.78.",
    ],
    ('["S1", "S3"]', '["S1", "S3"]\nrepetitions = 1000\npause_s = 1e23\ncontact_s = 11'): [
        "13: experiment.repetitions: expected a number <= 999, but found 1000.",
        "14: experiment.pause_s: expected a number <= 3600, but found 1e+23.",
        "15: experiment.contact_s: expected a number <= 10, but found 11.",
    ],
    ('["S1", "S3"]', '["S1", "S3"]\nangles_deg = { constant-min = [0, 89.5] }'): [
        "15: emulated.angle_sd_deg: expected an angle_sd_deg of which two added to 89.5 degrees stay below 90, but "
        "found 0.5.",
    ],
    ('["S1", "S3"]', '["S1", "S3"]\nschedule_of = { S1 = "S1" }'): [
        '13: experiment.schedule_of.S1: expected another specimen, but found "S1". Leave it out: a specimen is '
        "pressed with its own schedules where nothing is said.",
    ],
    ('["S1", "S3"]\n\n[emulated]', '["S1", "S3"]\nschedule_of = { S1 = "S3" }\n[emulated]\ncontrol = "N3"'): [
        '13: experiment.schedule_of: expected no schedule_of beside control = "N3", which swaps the schedules '
        "itself, but found S1 = S3. Leave it out, or choose another control.",
    ],
    ("[emulated]", "[camera]\nsource = 0\nheight = 3000\nwidth = 4000\nrate_hz = 120\n[emulated]"): [
        "16: camera.height: expected less than 4 GiB of frames in a press, but found up to 4.1 GiB: 4000 x 3000 "
        "pixels for 3.05 s. Choose smaller frames, a lower rate_hz, or a faster ramp.",
    ],
    (MOTOR, ""): [
        "1: motor: expected a table [motor], as the experiment has the condition high-stiffness, but found nothing. "
        "Add it, or give angles_deg without high-stiffness.",
    ],
    (MOTOR, MOTOR.replace("USB1", "USB0")): [
        "4: motor.id: expected a board of its own, but found id 1 at /dev/ttyUSB0, as for [actuator]. Give one of "
        "them another id; emg2vsa rig scan lists who answers.",
    ],
    ("[emulated]", "[emulated]\nstiffness_n_per_mm = { S1 = 1, S3 = -2 }\nspring = 1"): [
        "15: emulated.stiffness_n_per_mm.S3: expected a number > 0, but found -2.",
        "16: emulated.spring: expected a known key, but found 'spring'. Did you mean 'springs'?",
    ],
    (
        "[emulated]",
        '[emulated]\nrelaxation = { S1 = 0.9, S2 = -0.1 }\nfriction = 3\nworld = "hard"\nlate_frames_s = 0.05',
    ): [
        "15: emulated.relaxation.S1: expected a number <= 0.75, but found 0.9.",
        "15: emulated.relaxation.S2: expected a number >= 0, but found -0.1.",
        "16: emulated.friction: expected a number <= 2, but found 3.",
        "17: emulated.world: expected 'viscoelastic' or 'elastic', but found \"hard\".",
        "18: emulated.late_frames_s: expected a number <= 0.04, but found 0.05.",
    ],
    ("[emulated]", '[emulated]\nsprings = "qbmove-advanced"'): [
        '15: emulated.springs: expected qbmove-maker-pro, as [actuator] has the model "maker-pro", but found '
        '"qbmove-advanced". Leave springs out, or correct [actuator].',
    ],
    ("[emulated]", "[emulated]\nrelaxation = { S11 = 0.1 }\nfriction = 0.3\nfriction_drop = 0.2"): [
        '15: emulated.relaxation.S11: expected a specimen of stiffness_n_per_mm, but found "S11". Did you mean '
        "'S1'?",
        "17: emulated.friction_drop: expected at most half of emulated.friction, 0.3, but found 0.2.",
    ],
    ("[emulated]", "[emulated]\ndome_radius_mm = 25"): [
        "15: emulated.dome_radius_mm: expected it beside domes, but found 25.0. Give domes, or leave dome_radius_mm "
        "out."
    ],
    ("[emulated]", '[emulated]\ndomes = "mine"\nskin = "sticking"'): [
        '15: emulated.domes: expected skin = "finite-elements" beside it, but found "sticking". Leave one of the two '
        "out."
    ],
    ("[emulated]", "[emulated]\nheight_mm = { S11 = 10 }"): [
        '15: emulated.height_mm.S11: expected a specimen of stiffness_n_per_mm, but found "S11". Did you mean '
        "'S1'?",
    ],
    ("[emulated]", '[emulated]\nheight_mm = { S1 = 0.5, S3 = 2000, S2 = "thick" }'): [
        "15: emulated.height_mm.S1: expected a number >= 1, but found 0.5.",
        "15: emulated.height_mm.S3: expected a number <= 1000, but found 2000.",
        '15: emulated.height_mm.S2: expected a number, but found "thick".',
    ],
    ("[emulated]", '[emulated]\nworld = "elastic"\nfriction = 0.3'): [
        '16: emulated.friction: expected a key that world = "elastic" has, but found 0.3. Remove the key, or set '
        'world to "viscoelastic".',
    ],
    ("[emulated]", "[camera]\nsource = -1"): [
        "15: camera.source: expected a number >= 0 or text in quotes, but found -1.",
    ],
    ("[emulated]", "[rig]\nstiffness_percent = [80, 20]\npush_axis = [0, 0, 2]\nhome_ticks = 6000"): [
        "15: rig.stiffness_percent: expected the smaller of two different numbers first, but found [80.0, 20.0].",
        "16: rig.push_axis: expected a direction of length 1, but found one of length 2. Along z it is [0, 0, 1].",
        "14: rig.travel_mm: expected every depth within position_deg, -131.836 to 131.836, but found 15 mm at "
        "140.918 degrees.",
    ],
    ("[emulated]", "[rig]\nhome_ticks = 13000\nposition_ticks = [-12000, 12000]"): [
        "15: rig.home_ticks: expected every depth within position_deg, -131.836 to 131.836, but found 0 mm at "
        "142.822 degrees. home_ticks = 13000 is read as home_deg = 142.822265625.",
        "14: rig.travel_mm: expected every depth within position_deg, -131.836 to 131.836, but found 15 mm at "
        "217.822 degrees.",
    ],
    ("[emulated]", "[rig]\nhome_ticks = 2\nhome_deg = 0.5\n[rig.guards]\ncurrent_ma = 100\ncurrent_a = 9"): [
        "15: rig.home_ticks: expected one key, home_deg or home_ticks, but found both. Remove one of them; "
        "home_ticks is that of versions up to 0.2.0.",
        "18: rig.guards.current_ma: expected one key, current_a or current_ma, but found both. Remove one of them; "
        "current_ma is that of versions up to 0.2.0.",
        "19: rig.guards.current_a: expected a number <= 6, but found 9.",
    ],
    (
        "[emulated]",
        '[rig]\nhome_ticks = 1.5\nposition_ticks = [-12000, 0.5]\nmax_preset_ticks = 0\nguards = '
        '{ following_ticks = 700, current_ma = "1500" }',
    ): [
        "15: rig.home_ticks: expected a whole number, but found 1.5.",
        "16: rig.position_ticks[1]: expected a whole number, but found 0.5.",
        "17: rig.max_preset_ticks: expected a number > 0, but found 0.0. max_preset_ticks = 0 is read as "
        "full_preset = 0.0.",
        "18: rig.guards.following_ticks: expected a number <= 6.6, but found 7.6904296875. following_ticks = 700 is "
        "read as following_deg = 7.6904296875.",
        '18: rig.guards.current_ma: expected a number, but found "1500". Write it without quotes.',
    ],
    ("[emulated]", "[rig]\nposition_ticks = [1]\nfollowing_ticks = 3\n[rig.losses]\nhome_ticks = 3"): [
        "15: rig.position_ticks[1]: expected one more entry, but found nothing. position_ticks = [1] is read as "
        "position_deg = [0.010986328125].",
        "16: rig.following_ticks: expected a known key, but found 'following_ticks'. The keys are "
        "gear_mm_per_degree, travel_mm, home_deg, push_sign, position_deg, full_preset, stiffness_percent, "
        "push_axis, rate_hz, filter_samples, dome_modulus_mpa, dome_modulus_sd_percent, max_mm_per_s, escape_mm_per_s, "
        "settle_s, record_full_rate_force, losses, guards.",
        "18: rig.losses.home_ticks: expected a known key, but found 'home_ticks'. The keys are late_turns_percent, "
        "missing_turns_percent, lost_force_percent, missing_frames_percent.",
    ],
    ("[emulated]", f"[rig]\nhome_ticks = {10**400}\n[rig.guards]\nfollowing_ticks = nan\ncurrent_ma = inf"): [
        f"15: rig.home_ticks: expected a finite number, but found 1{56 * '0'}....",
        "17: rig.guards.following_ticks: expected a finite number, but found NaN.",
        "18: rig.guards.current_ma: expected a finite number, but found Infinity.",
    ],
    (
        "[emulated]",
        f"[rig]\ngear_mm_per_degree = 1e308\nmax_preset_ticks = {10**17}\nguards.following_ticks = 1e308",
    ): [
        "15: rig.gear_mm_per_degree: expected a number <= 100, but found 1e+308.",
        "17: rig.guards.following_ticks: expected a number <= 6.6, but found 1.0986328125e+306. following_ticks = "
        "1e+308 is read as following_deg = 1.0986328125e+306.",
    ],
    ("[emulated]", "[rig.guards]\nstale_s = 0.005\nforce = 3"): [
        "15: rig.guards.stale_s: expected more than a period of the loop, 0.005 s, but found 0.005.",
        "16: rig.guards.force: expected a known key, but found 'force'. Did you mean 'force_n'?",
    ],
    ("[emulated]", "[rig]\ndome_modulus_mpa = 0\ndome_modulus_sd_percent = 51\n[rig.guards]\nspecimen_share = 1.5"): [
        "15: rig.dome_modulus_mpa: expected a number > 0, but found 0.",
        "16: rig.dome_modulus_sd_percent: expected a number <= 50, but found 51.",
        "18: rig.guards.specimen_share: expected a number <= 1, but found 1.5.",
    ],
    ("[emulated]", "[rig]\nrate_hz = 49"): ["15: rig.rate_hz: expected a number >= 50, but found 49."],
    ("[emulated]", "[rig]\nmax_mm_per_s = 15\n[rig.guards]\nmotors_every_s = 0.25"): [
        "14: rig.escape_mm_per_s: expected at most rig.max_mm_per_s, 15, but found 20.",
        *(
            f"17: rig.guards.motors_every_s: expected less than half of {board}.watchdog_s, 0.5: "
            "questions keep it from running out, but found 0.25."
            for board in ("actuator", "motor")
        ),
    ],
    ('["S1", "S3"]', '["S1"]\nramp_mm_per_s = 41\nstiffness_n_per_mm = { S1 = 7, S2 = 5 }'): [
        "13: experiment.ramp_mm_per_s: expected at most rig.max_mm_per_s, 40, but found 41.",
        '14: experiment.stiffness_n_per_mm.S2: expected a specimen of the experiment, but found "S2". Did you mean '
        "'S1'?",
    ],
}  # fmt: skip
"""What is replaced in the small file, and by what, to what is then said of it."""


@pytest.mark.parametrize(("old", "new"), BAD)
def test_bad_files(old: str, new: str, small: str, problems: Problems) -> None:
    assert old in small
    assert problems(small.replace(old, new, 1)) == sorted(BAD[old, new], key=lambda line: int(line.partition(":")[0]))


@pytest.mark.parametrize("guard", [each.name for each in fields(GuardSettings)])
def test_no_guard_may_pass_its_bound(guard: str, small: str, problems: Problems) -> None:
    value = "1" if guard.startswith("following_deg_per_s") else "1e9"
    (line,) = problems(small.replace("[emulated]", f"[rig.guards]\n{guard} = {value}\n[emulated]", 1))
    assert line.startswith(f"15: rig.guards.{guard}: expected a number ")


@pytest.mark.parametrize(
    ("guard", "value", "wanted"),
    [
        ("following_ticks", 601, "<= 6.6, but found 6.602783203125. following_ticks = 601 is read as following_deg = "),
        ("following_ticks", 0, "> 0, but found 0.0. following_ticks = 0 is read as following_deg = 0.0."),
        ("following_ticks_per_s", 2994, ">= 32.9, but found 32.89306640625. following_ticks_per_s = 2994 is read as "),
        ("following_ticks_per_s", 61000, "<= 660, but found 670.166015625. following_ticks_per_s = 61000 is read as "),
        ("current_ma", 6001, "<= 6, but found 6.001. current_ma = 6001 is read as current_a = 6.001."),
    ],
)
def test_no_guard_may_pass_its_bound_in_ticks(
    guard: str, value: int, wanted: str, small: str, problems: Problems
) -> None:
    (line,) = problems(small.replace("[emulated]", f"[rig.guards]\n{guard} = {value}\n[emulated]", 1))
    assert line.startswith(f"15: rig.guards.{guard}: expected a number {wanted}")


@pytest.mark.parametrize("line", ["max_mm_per_s = 201", "escape_mm_per_s = 4", "settle_s = 3"])
def test_no_speed_or_time_of_the_way_out_may_pass_its_bound(line: str, small: str, problems: Problems) -> None:
    (said,) = problems(small.replace("[emulated]", f"[rig]\n{line}\n[emulated]", 1))
    assert said.startswith(f"15: rig.{line.partition(' ')[0]}: expected a number ")


def test_problems_of_all_tables_at_once(small: str, problems: Problems) -> None:
    bad = small.replace('kind = "net-ft"', "").replace("[motor]", "[moter]")
    bad = bad.replace("[emulated]", "repetitions = 0")
    assert [line.partition(": expected")[0] for line in problems(bad)] == [
        "1: motor", "4: moter", "7: force.kind", "14: experiment.repetitions",
    ]  # fmt: skip


def test_a_file_that_is_no_toml_or_not_there(tmp_path: Path, problems: Problems) -> None:
    (line,) = problems("[rig\n")
    assert line.startswith("1:5: expected valid TOML, but the parser says: ")
    with pytest.raises(StudyError, match=r"none\.toml: expected a rig file, but found no file that can be read"):
        load_rig(tmp_path / "none.toml")
