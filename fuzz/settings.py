"""Bytes of TOML go in, to be read as settings, a machine, or settings of a training."""

from __future__ import annotations

from fuzz.contract import file_of
from limner.cli.options import read_text
from limner.motion.machine import load_machine
from limner.pipeline import Settings
from limner.settings import read_toml, write_toml
from limner.units import parse_length_mm, parse_page, parse_time_s
from limner.vision.landmarks.fmp.train_settings import TrainSettings


def settings(data: bytes) -> None:
    """A file of settings; what was read can be written and read again."""
    with file_of(data, "settings.toml") as path:
        tree = read_toml(Settings, read_text(path))
    assert read_toml(Settings, write_toml(tree)) == tree


def assigned(data: bytes) -> None:
    """One setting by name, as ``--set NAME=VALUE`` gives it."""
    path, _, text = data.decode("utf-8", "surrogateescape").partition("=")
    Settings().assign(path, text)


def machine(data: bytes) -> None:
    """A machine of one's own, and what its estimates need."""
    with file_of(data, "machine.toml") as path:
        load_machine(str(path)).cost_model()


def training(data: bytes) -> None:
    """Settings of a training."""
    read_toml(TrainSettings, data.decode("utf-8", "replace"))


def quantities(data: bytes) -> None:
    """Lengths, times and pages as people write them."""
    text = data.decode("utf-8", "replace")
    kind, _, rest = text.partition(" ")
    {"length": parse_length_mm, "time": parse_time_s}.get(kind, parse_page)(rest)


HARNESSES = {
    "settings": settings,
    "assigned": assigned,
    "machine": machine,
    "training": training,
    "quantities": quantities,
}
