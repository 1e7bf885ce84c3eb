"""The studio's description of itself holds: every route is in it, and whatever fits it is answered as it says."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

import studios

# Each needs data that the tool cannot know, or is a matter of taste.
NOT_ASKED = (
    "positive_data_acceptance",
    "negative_data_rejection",
    "unsupported_method",
    "ignored_auth",
    "missing_required_header",
    "allow_header_conformance",
)


@pytest.fixture(scope="module")
def server():
    with studios.serving("--booth") as server:
        yield server


def test_every_route_is_described(server):
    with studios.enter(server) as client:
        described = client.get("/api/openapi.json").json()
    operations = [
        (path, method, told) for path, methods in described["paths"].items() for method, told in methods.items()
    ]
    assert len(operations) > 25
    for path, method, told in operations:
        assert told["summary"].endswith("."), f"{method} {path}"
        assert any(status.startswith("2") for status in told["responses"])
    protocol = (Path(__file__).parents[1] / "docs" / "studio-protocol.md").read_text()
    for path in described["paths"]:
        head = path.partition("{")[0].rstrip("/")
        assert head in protocol or head.rpartition("/")[2] in protocol, f"{path} is not in docs/studio-protocol.md"


@pytest.mark.slow
def test_nothing_that_fits_the_description_breaks_the_server(server, tmp_path):
    pytest.importorskip("schemathesis")
    with studios.enter(server) as client, studios.enter(server, server.said["operator_url"]) as operator:
        jar = [*client.cookies.items(), *operator.cookies.items()]
        cookie = "; ".join(f"{name}={value}" for name, value in jar)
        tool = Path(sys.executable).parent / "st"
        ran = subprocess.run(
            [
                *(tool, "run", f"{server.base}/api/openapi.json", "-H", f"Cookie: {cookie}", "--max-examples", "6"),
                *("--request-timeout", str(studios.PATIENCE_S)),
                *("--phases", "coverage,fuzzing", "--seed", "1", "--exclude-checks", ",".join(NOT_ASKED)),
            ],
            capture_output=True,
            text=True,
            timeout=900,
            cwd=tmp_path,
        )
        assert ran.returncode == 0, ran.stdout[-4000:] + ran.stderr[-1000:]
        assert client.get("/api/options").status_code == 200
