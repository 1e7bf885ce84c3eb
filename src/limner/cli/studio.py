"""``limner studio``: a page in the browser of this computer, from a photo to the machine."""

from __future__ import annotations

import json
import threading
import webbrowser
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from limner.cli.jobs import Job
    from limner.pipeline import Settings
    from limner.studio.orders import Order

BAUD = 115_200
"""Of serial ports, as ``limner send`` takes it."""


@click.command(short_help="Open the studio: from a photo to the machine, in the browser.")
@click.option("--port", type=click.IntRange(1, 65535), metavar="N", help="Listen there. Default: a free one.")
@click.option(
    "--host",
    default="127.0.0.1",
    metavar="HOST",
    help="Listen there. Default: 127.0.0.1, which only this computer reaches.",
)
@click.option("--booth", is_flag=True, help="The booth: full screen for guests, and a page for who operates it.")
@click.option("--no-browser", is_flag=True, help="Open no browser.")
@click.option(
    "--settings",
    type=click.Path(path_type=Path),
    metavar="FILE",
    help="Begin with settings from a TOML file, which may also name files of models.",
)
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object on stdout and nothing else.")
def studio(
    port: int | None,
    host: str,
    booth: bool,
    no_browser: bool,
    settings: Path | None,
    as_json: bool,
) -> None:
    """Serve the studio at an address with a token that nobody else knows, until Ctrl-C.

    Photos stay in the memory of this computer and are gone when it ends. With --json the address is printed as
    {"url", "operator_url"}.
    """
    from limner.studio.serve import Address, serve

    def ready(address: Address) -> None:
        if not address.loopback:
            click.echo(
                f"warning: others in the network can reach {host}, and read along: the address is http", err=True
            )
        if as_json:
            click.echo(json.dumps({"url": address.url, "operator_url": address.operator_url}))
        else:
            click.echo(f"studio: {address.url}")
            if address.operator_url:
                click.echo(f"operator: {address.operator_url}")
            click.echo("Ctrl-C ends it; photos are kept nowhere", err=True)
        if not no_browser:
            # Some browsers run in this terminal and would keep the server from answering them.
            threading.Thread(target=webbrowser.open, args=(address.url,), daemon=True).start()

    serve(_read(settings) if settings else {}, make, host, port, booth=booth, ready=ready)


def _read(path: Path) -> dict[str, Any]:
    """Settings of a file, checked; it takes a moment, which the page need not wait for without one."""
    from limner.cli.options import read_text
    from limner.pipeline import Settings
    from limner.settings import read_toml

    return read_toml(Settings, read_text(path)).to_dict()


def make(order: Order, file: str) -> Job:
    """What draws an order of the studio's, as ``limner send`` does.

    Args:
        order: to whom, as what.
        file: of the drawing, or of a robot's motion.

    Raises:
        LimnerError: why it cannot be drawn.
    """
    from limner.cli import jobs
    from limner.pipeline import Settings

    settings = Settings.from_dict(order.settings)
    if order.robot:
        return jobs.arm(file, order.to, order.robot, settings)
    return jobs.plotter(file, order.to, order.machine, False, BAUD, raised(settings) if order.frame_only else settings)


def raised(settings: Settings) -> Settings:
    """Settings by which a lowered pen is as high as a raised one, to a step of its servo."""
    gcode, ebb = settings.gcode, settings.ebb
    servo = gcode.servo_up + (1 if gcode.servo_up < gcode.servo_down else -1)
    return settings.replace(
        gcode=gcode.replace(servo_down=servo, z_down_mm=gcode.z_up_mm - 0.01), ebb=ebb.replace(pen_down=ebb.pen_up)
    )
