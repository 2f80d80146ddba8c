"""Streams of the Lab Streaming Layer that this program sends."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

SESSION_SOURCE = "emg2vsa-session-"
"""The source id of each stream that a session sends begins so."""


def outlet(
    lsl: Any, name: str, kind: str, labels: Sequence[str], unit: str, fs_hz: float, source: str,
    form: str = "float32", **about: str,
) -> Any:  # fmt: skip
    """An outlet of pylsl, which other programs can find at once.

    kind : its type, as LSL calls it ("EMG", "Markers"). labels, unit : of its channels. fs_hz : rate, Hz; 0 for an
        irregular one.
    source : its id, by which an inlet finds it again after a new start. about : of the sender.
    """
    info = lsl.StreamInfo(name, kind, len(labels), fs_hz, form, source)
    description = info.desc()
    for key, value in about.items():
        description.append_child_value(key, value)
    channels = description.append_child("channels")
    for label in labels:
        channel = channels.append_child("channel")
        for key, value in (("label", label), ("unit", unit), ("type", kind)):
            channel.append_child_value(key, value)
    return lsl.StreamOutlet(info)
