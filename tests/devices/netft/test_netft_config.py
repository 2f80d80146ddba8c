"""Scales, units and rates from the box's page; the tags are those of a live box (firmware 2.2.59)."""

from __future__ import annotations

import pytest

from emg2vsa.devices.netft.box import fetch_config, parse_config
from emg2vsa.errors import DeviceError

TAGS = {
    "runrate": "7000",
    "cfgcalsn": "FT12345",
    "scfgfu": "N",
    "scfgtu": "Nm",
    "cfgcpf": "1000000",
    "cfgcpt": "1000000",
    "comrdte": "Enabled",
    "comrdtrate": "100",
}


def page(**changes: str | None) -> bytes:
    tags = {tag: text for tag, text in (TAGS | changes).items() if text is not None}
    inner = "".join(f"<{tag}>{text}</{tag}>\n" for tag, text in tags.items())
    return f'<?xml version="1.0"?><netft>\n{inner}</netft>'.encode()


def test_a_live_net_ft_box():
    config = parse_config(page())
    assert config.n_per_count == config.nm_per_count == 1e-6
    assert config.rate_hz == 100
    assert (config.axia, config.product, config.calibration_serial) == (False, "", "FT12345")


@pytest.mark.parametrize(
    ("told", "force_n"),
    [("145;145;290;5;5;5", (145, 145, 290)), ("145;145;290;5;5;5;", (145, 145, 290)), ("145;145", None), ("", None),
     ("0;1;1;1;1;1", None), ("a;1;1;1;1;1", None)],
)  # fmt: skip
def test_the_rating_of_the_transducer(told: str, force_n: tuple[float, float, float] | None):
    rating = parse_config(page(cfgmr=told)).rating
    assert (rating and rating.force_n) == force_n
    pounds = parse_config(page(cfgmr="10;10;20;1;1;1", scfgfu="lbf")).rating
    assert pounds is not None
    assert pounds.force_n[2] == pytest.approx(88.96, abs=0.01)


def test_an_ethernet_axia():
    config = parse_config(page(prodname="Ethernet Axia", runrate=None))
    assert config.axia


@pytest.mark.parametrize(
    ("unit", "counts", "newton"),
    [
        ("N", "1000", 1e-3),
        ("kN", "1000", 1.0),
        ("lbf", "1", 4.4482216152605),
        ("klbf", "1000", 4.4482216152605),
        ("kgf", "10", 0.980665),
        ("gf", "1", 0.00980665),
    ],
)
def test_force_units(unit, counts, newton):
    assert parse_config(page(scfgfu=unit, cfgcpf=counts)).n_per_count == pytest.approx(newton, rel=1e-12)


@pytest.mark.parametrize(
    ("unit", "newton_metre"),
    [
        ("Nm", 1.0),
        ("N-m", 1.0),
        ("Nmm", 1e-3),
        ("N-mm", 1e-3),
        ("kNm", 1e3),
        ("lbf-in", 0.1129848290276167),
        ("lbf-ft", 1.3558179483314004),
        ("kgf-cm", 0.0980665),
    ],
)
def test_torque_units(unit, newton_metre):
    assert parse_config(page(scfgtu=unit, cfgcpt="1")).nm_per_count == pytest.approx(newton_metre, rel=1e-12)


@pytest.mark.parametrize(
    ("changes", "named"),
    [
        ({"cfgcpf": None}, "cfgcpf"),
        ({"cfgcpf": "0"}, "cfgcpf"),
        ({"cfgcpt": "nan"}, "cfgcpt"),
        ({"cfgcpt": "many"}, "many"),
        ({"scfgfu": "stone"}, "stone"),
        ({"scfgtu": None}, "scfgtu"),
        ({"comrdtrate": None}, "comrdtrate"),
        ({"comrdte": "Disabled"}, "Enable RDT"),
    ],
)
def test_a_page_that_makes_no_sense(changes, named):
    with pytest.raises(DeviceError, match=named):
        parse_config(page(**changes))


def test_no_xml():
    with pytest.raises(DeviceError, match="as XML"):
        parse_config(b"<netft><cfgcpf>")


def test_nobody_there():
    with pytest.raises(DeviceError, match=r"127\.0\.0\.1:1/netftapi2\.xml"):
        fetch_config("127.0.0.1", 1, timeout_s=0.5)
