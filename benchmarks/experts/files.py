"""EDF and BDF decoded from one read of the file, and numbers of a CSV file."""

from __future__ import annotations

from pathlib import Path

import numpy as np

VOLTS = {b"uV": 1e-6, b"mV": 1e-3}


def edf(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Channels of a file of one rate in SI units; ValueError where the header is another, or the file is cut short."""
    data = path.read_bytes()
    size, records, count = int(data[184:192]), int(data[236:244]), int(data[252:256])
    width = 3 if data[:1] == b"\xff" else 2
    head = data[256:size]

    def field(start: int, length: int) -> list[bytes]:
        return [head[count * start + i * length :][:length].strip() for i in range(count)]

    labels, units = field(0, 16), field(96, 8)
    low, high, least, most = (np.array(field(at, 8), dtype=np.float64) for at in (104, 112, 120, 128))
    samples = np.array(field(216, 8), dtype=np.int64)
    begins, step = np.cumsum(samples) - samples, int(samples.sum())
    if len(data) - size != records * step * width:
        raise ValueError("the file is not as long as its header says")
    raw = np.frombuffer(data, np.uint8, offset=size).reshape(records, step * width)
    found = {}
    for name in names:
        i = labels.index(name.encode())
        part = raw[:, begins[i] * width : (begins[i] + samples[i]) * width]
        if width == 2:
            whole = np.ascontiguousarray(part).view("<i2").astype(np.float64)
        else:
            wide = np.empty((records, samples[i], 4), np.uint8)  # the three bytes above an empty one
            wide[..., 1:] = part.reshape(records, samples[i], 3)
            whole = (wide.view("<i4")[..., 0] >> 8).astype(np.float64)
        gain = (high[i] - low[i]) / (most[i] - least[i])
        whole *= gain * VOLTS.get(units[i], 1.0)
        whole += (low[i] - least[i] * gain) * VOLTS.get(units[i], 1.0)
        found[name] = whole.reshape(-1)
    return found


def csv(path: Path, names: tuple[str, ...]) -> dict[str, np.ndarray]:
    """Columns that begin with the names, by the parser of pandas in C, its fast rounding, and no index."""
    import pandas as pd

    with path.open() as file:
        head = file.readline().strip().split(",")
    at = [next(i for i, title in enumerate(head) if title.startswith(name)) for name in names]
    table = pd.read_csv(
        path, header=None, skiprows=1, usecols=[0, *at], dtype=np.float64, engine="c", float_precision=None
    )
    if not np.allclose(np.diff(table[0].to_numpy()), table[0][1] - table[0][0], rtol=1e-3):
        raise ValueError("samples are not evenly apart")
    return {name: table[i].to_numpy() for name, i in zip(names, at, strict=True)}
