from __future__ import annotations

import pytest

from emg2vsa.authors.contents import description, encoding_format


@pytest.mark.parametrize(
    ("name", "kind", "said"),
    [
        ("results.json", "application/json", "Every number by name"),
        ("figures/fig08.pdf", "application/pdf", "Figure fig08, vector"),
        ("tables/pairs.csv", "text/csv", "Table pairs, every digit"),
        ("something/new.xyz", "application/octet-stream", "Result new"),
    ],
)
def test_every_file_has_a_media_type_and_a_line(name, kind, said):
    assert encoding_format(name) == kind
    assert description(name).startswith(said)
