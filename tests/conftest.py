"""Shared fixtures: the folder of data that may lie beside the checkout, the command line; which slow tests run."""

from __future__ import annotations

import os
import signal
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

SHARED = Path(__file__).parents[2] / "shared"
SLOW_SAMPLE = 3
"""Every how many-th slow test runs when LIMNER_SLOW is not set."""

EXPLORES = os.environ.get("LIMNER_SLOW") == "1"
"""Whether properties are tried on other examples each time; else a run is the same each time."""

HANGS_S = 900
"""A test that takes longer hangs, and fails."""

# A busy machine is no failure.
settings.register_profile(
    "limner", deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=not EXPLORES, database=None
)
settings.load_profile("limner")

# Begun in the background or under nohup, tests and every program they begin would ignore what they are ended by.
for number, usual in (("SIGINT", signal.default_int_handler), ("SIGHUP", signal.SIG_DFL)):
    if hasattr(signal, number) and signal.getsignal(getattr(signal, number)) is signal.SIG_IGN:
        signal.signal(getattr(signal, number), usual)


@pytest.fixture(scope="session")
def shared() -> Path:
    """The folder ``shared`` beside the checkout; tests that need it skip where it is absent."""
    if not SHARED.is_dir():
        pytest.skip("needs the folder 'shared' (data and reference numbers) beside the checkout")
    return SHARED


@pytest.fixture(autouse=True)
def no_test_hangs():
    """Where a test would wait for ever it fails, and tells where it waited."""
    if not hasattr(signal, "SIGALRM"):
        yield
        return

    def late(number, frame):
        pytest.fail(f"the test has taken {HANGS_S} s")

    before = signal.signal(signal.SIGALRM, late)
    signal.setitimer(signal.ITIMER_REAL, HANGS_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


@pytest.fixture
def command(monkeypatch, capfd, tmp_path):
    """``limner`` in this process, in an empty folder, through its own ``main``: exit code, stdout and stderr."""
    from limner.cli import main

    def command(*words):
        monkeypatch.chdir(tmp_path)
        monkeypatch.setattr(sys, "argv", ["limner", *map(str, words)])
        capfd.readouterr()
        with pytest.raises(SystemExit) as ended:
            main()
        return ended.value.code, *capfd.readouterr()

    return command


def pytest_collection_modifyitems(config, items):
    """Keep every third slow test, all of them with LIMNER_SLOW=1 or when one is asked for by name."""
    if EXPLORES or config.option.markexpr or config.option.keyword:
        return
    if any("::" in str(arg) for arg in config.args):
        return
    slow = [item for item in items if "slow" in item.keywords]
    left_out = [item for i, item in enumerate(sorted(slow, key=lambda item: item.nodeid)) if i % SLOW_SAMPLE]
    if left_out:
        config.hook.pytest_deselected(items=left_out)
        items[:] = [item for item in items if item not in left_out]


@pytest.hookimpl(trylast=True)
def pytest_terminal_summary(terminalreporter):
    """With CI set a skipped test is a failure: what CI does not run nobody runs."""
    skipped = terminalreporter.stats.get("skipped", [])
    if os.environ.get("CI") == "true" and skipped:
        terminalreporter.section("skipped tests are failures where CI=true", red=True)


def pytest_sessionfinish(session, exitstatus):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if os.environ.get("CI") == "true" and reporter and reporter.stats.get("skipped") and exitstatus == 0:
        session.exitstatus = 1
