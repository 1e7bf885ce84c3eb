"""The studio is measured as its page uses it; that the numbers are good is not for a busy machine to say."""

from __future__ import annotations

import pytest

pytest.importorskip("uvicorn")

from limner.cli.evaluate import astronaut
from limner.evaluate.studio import SLIDERS, measure_studio
from limner.vision.photo import load_photo


@pytest.mark.slow
def test_every_number_is_measured():
    rows = {row.name: row for row in measure_studio(load_photo(astronaut()), runs=1, photos=4)}
    assert rows["start to first answer"].value > 0
    for slider in SLIDERS:
        assert rows[f"slider to preview, {slider}"].goal == 300
        assert rows[f"slider to preview, {slider}"].value > 0
    assert any(name.startswith("memory") for name in rows)
