"""Calibrations on disk: read back as they were written, refused when they are not that."""

from __future__ import annotations

import json

import numpy as np
import pytest

from emg2vsa.calibration.cut_presses import cut_forces
from emg2vsa.calibration.online import OnlineCalibration, OnlineEstimator
from emg2vsa.calibration_file import _digest, file_name, open_calibration, write_calibration
from emg2vsa.errors import DataError
from emg2vsa.settings import CalibrationSettings


@pytest.fixture(scope="module")
def calibration():
    kappa, forces = np.array([7.63, 3.35, 1.11]), cut_forces(0.5, 7.0)
    rng = np.random.default_rng(0)
    casr = (1 / kappa + 1 / 4) ** (2 / 3)
    rates = casr[:, None, None] * forces**-0.3 * (1 + 0.02 * rng.standard_normal((3, 5, 1)))
    mounting = np.tile([1, 1, 1, 2, 2], (3, 1))
    mounting[2, 4], rates[2, 4], rates[0, 0, -3:] = 0, np.nan, np.nan
    return OnlineCalibration(
        specimens=("S1", "S3", "S5"), kappa=kappa, kappa_se=np.array([0.1, 0.0, 0.02]), quantity="front",
        area_unit="mm2", angle_deg=30.0, condition="modular", start_n=0.5, forces_n=forces, rates=rates,
        mounting=mounting, settings=CalibrationSettings(confidence=0.9), growth=0.6,
        simulated=True, provenance={"study": "palpation"},
    )  # fmt: skip


@pytest.fixture
def path(tmp_path, calibration):
    return write_calibration(tmp_path / file_name(calibration), calibration)


def test_it_reads_back_as_it_was_written(calibration, path):
    assert path.name == "modular_30.json"
    again = open_calibration(path)
    for name in calibration.__dataclass_fields__:
        np.testing.assert_equal(getattr(again, name), getattr(calibration, name))
    press = np.linspace(0.5, 7, 40)
    states = [
        [OnlineEstimator(each).push(force, 5 * force**0.5) for force in press][-1] for each in (calibration, again)
    ]
    assert states[0] == states[1]


def test_the_same_calibration_gives_the_same_bytes(tmp_path, calibration, path):
    assert write_calibration(tmp_path / "again.json", open_calibration(path)).read_bytes() == path.read_bytes()


def test_a_file_that_is_not_there_or_not_json_is_refused(tmp_path):
    with pytest.raises(DataError, match=r"none\.json: expected a calibration file, but found No such file"):
        open_calibration(tmp_path / "none.json")
    with pytest.raises(DataError, match="expected a calibration file"):
        open_calibration(tmp_path)
    for text, found in (("{", "expected a JSON object"), ("[]", "found list"), ("{}", "format")):
        (tmp_path / "bad.json").write_text(text)
        with pytest.raises(DataError, match=found):
            open_calibration(tmp_path / "bad.json")
    (tmp_path / "bad.json").write_bytes(b"\xff\xfe")
    with pytest.raises(DataError, match="not text"):
        open_calibration(tmp_path / "bad.json")


def test_a_value_changed_by_hand_is_refused(path):
    path.write_text(path.read_text().replace('"kappa_n_per_mm": 7.63', '"kappa_n_per_mm": 7.64'))
    with pytest.raises(DataError, match="sha256: expected the digest of the content"):
        open_calibration(path)


def sealed(path, **changed):
    document = json.loads(path.read_text()) | changed
    document.pop("sha256")
    path.write_text(json.dumps(document | {"sha256": _digest(document)}))
    return path


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"format": "schedule"}, "format: expected 'emg2vsa calibration', but found 'schedule'"),
        ({"version": 1}, "version: expected version 2, but found 1"),
        ({"version": True}, "version: expected version 2"),
        ({"quantity": "depth"}, "quantity: expected front or edge"),
        ({"area_unit": "m2"}, "area_unit: expected mm2 or px2, but found 'm2'"),
        ({"force_n": {"start": 0.5, "judged_at": [2.0, 1.0]}}, "force_n: expected rising forces"),
        ({"specimens": []}, "specimens: expected two specimens or more, but found 0"),
        ({"settings": {"law": "magic"}}, "settings: expected a law that can be fitted, but found 'magic'"),
        ({"settings": {"speed": 1}}, "expected the keys of a calibration"),
        ({"provenance": None}, "expected the keys of a calibration"),
    ],
)
def test_one_clear_error_for_a_file_that_says_something_else(path, changed, complaint):
    with pytest.raises(DataError, match=complaint):
        open_calibration(sealed(path, **changed))


def test_presses_need_a_rate_for_every_force(path):
    specimens = json.loads(path.read_text())["specimens"]
    specimens[1]["presses"][2]["rates"].pop()
    with pytest.raises(DataError, match=r"specimens 2, press 3: expected 31 rates, but found 30\."):
        open_calibration(sealed(path, specimens=specimens))


@pytest.mark.parametrize(
    ("change", "complaint"),
    [
        (lambda d: d["settings"].update(confidence=5), "settings, confidence: expected a share between 0 and 1"),
        (lambda d: d["settings"].update(mounting_sd_percent=-1), "settings, mounting_sd_percent: expected 0 to below"),
        (lambda d: d.update(angle_deg=90), "angle_deg: expected 0 to below 90, but found 90"),
        (lambda d: d["force_n"]["judged_at"].__setitem__(-1, 1e300), "force_n: expected rising forces"),
        (lambda d: d["specimens"][0].update(kappa_n_per_mm=1e300), "kappa_n_per_mm: expected stiffnesses above 0"),
        (lambda d: d["specimens"][0].update(kappa_se_n_per_mm=-1), "kappa_se_n_per_mm: expected standard errors"),
        (lambda d: [each.update(kappa_n_per_mm=3) for each in d["specimens"]], "expected two different stiffnesses"),
        (lambda d: d["specimens"][0]["presses"][1].update(rates=[1e300] * 31), "press 2, rates: expected numbers"),
        (lambda d: [each.update(presses=[]) for each in d["specimens"]], "specimens 1: expected one press or more"),
        (
            lambda d: [press.update(rates=[None] * 31) for press in d["specimens"][1]["presses"]],
            "specimens 2: expected one press or more that reaches the largest force, but found 0",
        ),
        (
            lambda d: [d["specimens"][s].update(kappa_n_per_mm=k) for s, k in ((0, 1.11), (2, 7.63))],
            "specimens: expected CASR that rises with softness, but found one that does not. Check the stiffnesses",
        ),
    ],
)
def test_numbers_that_make_no_sense_are_named(path, change, complaint):
    document = json.loads(path.read_text())
    change(document)
    with pytest.raises(DataError, match=complaint) as error:
        open_calibration(sealed(path, **document))
    assert str(path) in str(error.value)


def test_a_constant_that_json_does_not_have_is_refused(path):
    path.write_text(path.read_text().replace('"angle_deg": 30.0', '"angle_deg": NaN'))
    with pytest.raises(DataError, match="a JSON object, but found NaN"):
        open_calibration(path)
