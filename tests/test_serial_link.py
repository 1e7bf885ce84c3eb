"""A real serial port's name goes in, behind which a fake sits on a pseudo-terminal; what is wrong with it is named."""

from __future__ import annotations

import errno
import sys

import pytest
import serial

from drawings import of
from limner.errors import BadInput, DeviceFailed, MissingExtra
from limner.targets.connect import Wiring, connect, parse_address
from limner.targets.ebb import EbbSettings, Limits
from limner.targets.fake import Fault
from limner.targets.fake_ebb import FakeEbb
from limner.targets.fake_grbl import FakeGrbl
from limner.targets.gcode import GcodeSettings
from limner.targets.journal import Journal
from limner.targets.link import LONGEST_LINE, Lines, Noise
from limner.targets.send import Control, send
from limner.targets.serial_link import SerialLink
from plotters import Served, counted, ebb, inked

DRAWING = of([[10, 190], [12, 190], [13, 189]], [[15, 190]], [[16, 190], [17, 191], [16, 190]])


def wiring(home=(0.0, 0.0)):
    return Wiring(home, ebb()[1]._plan, Limits(165, 2), GcodeSettings(), EbbSettings())


def draw(address, home, path):
    journal = Journal(path, DRAWING, resume=False)
    try:
        return send(DRAWING, connect(parse_address(address), wiring(home)), journal, Control(), lambda *_: None)
    finally:
        journal.close()


def test_grbl_over_a_port(tmp_path):
    fake = FakeGrbl()
    with Served(fake) as served:
        assert draw(f"grbl:{served.port}", (0.0, 0.0), tmp_path / "j").stroke == 3
    assert fake.breaches == []
    assert inked(fake) == counted(DRAWING.lines_mm)


def test_ebb_over_a_port(tmp_path):
    fake = FakeEbb(home=(0.0, 210.0))
    with Served(fake) as served:
        assert draw(f"ebb:{served.port}", (0.0, 210.0), tmp_path / "j").stroke == 3
    assert fake.breaches == []
    assert fake.steps == (0, 0)


@pytest.mark.parametrize("line", [0, 3, 8, 20])
def test_unplugged(tmp_path, line):
    with (
        Served(FakeGrbl(fault=Fault("unplug", line))) as served,
        pytest.raises(DeviceFailed, match="unplugged") as caught,
    ):
        draw(f"grbl:{served.port}", (0.0, 0.0), tmp_path / "j")
    assert "pen" in str(caught.value)


def test_noise_is_named():
    with Served(FakeGrbl()) as served:
        link = SerialLink(served.port, 115_200)
        served.fake.say("\x80\x81\xfe")
        with pytest.raises(Noise, match="no text"):
            Lines(link).next(1.0)
        served.fake._out += b"x" * 2 * LONGEST_LINE
        with pytest.raises(Noise, match="no text"):
            Lines(link).next(1.0)
        link.close()


def test_a_port_is_ours_alone():
    with Served(FakeGrbl()) as served:
        link = SerialLink(served.port, 115_200)
        with pytest.raises(DeviceFailed, match="in use"):
            SerialLink(served.port, 115_200)
        link.close()
        SerialLink(served.port, 115_200).close()


def test_what_is_wrong_with_a_port_is_named(tmp_path, monkeypatch):
    with pytest.raises(DeviceFailed, match="no such port"):
        SerialLink("/dev/ttyUSB99", 115_200)
    (tmp_path / "file").write_text("")
    with pytest.raises(DeviceFailed, match="no serial port"):
        SerialLink(str(tmp_path / "file"), 115_200)

    def refuse(*_, **__):
        raise serial.SerialException(errno.EACCES, "Permission denied")

    monkeypatch.setattr(serial, "Serial", refuse)
    with pytest.raises(DeviceFailed, match=r"no permission.*dialout"):
        SerialLink(str(tmp_path / "file"), 115_200)


def test_without_pyserial_it_says_what_to_install(monkeypatch):
    monkeypatch.setitem(sys.modules, "serial", None)
    with pytest.raises(MissingExtra, match=r"limner\[plotter\]"):
        SerialLink("/dev/ttyUSB0", 115_200)


@pytest.mark.parametrize("text", ["", "grbl", "grbl:", "marlin:/dev/ttyUSB0", "/dev/ttyUSB0", "fake", "fake:marlin"])
def test_addresses_are_checked(text):
    with pytest.raises(BadInput, match="grbl:PORT"):
        parse_address(text)
