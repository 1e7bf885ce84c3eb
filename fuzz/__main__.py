"""The names of harnesses and a time go in; each is run with coverage guidance for so long, and what it breaks on kept.

``python -m fuzz --time 600 svg gcode``; without names all of them. What breaks a promise is written to
``build/fuzz/NAME/crash-*``; inputs that reach new code stay in ``build/fuzz/NAME/found`` for the next time.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
from pathlib import Path

from fuzz import CORPUS, harnesses

BUILD = Path("build/fuzz")

_INSTRUMENTED = ["limner", "svgelements", "urdf_parser_py", "zipfile", "tomllib", "csv", "PIL"]


def main() -> int:
    """Run each in a process of its own: what kills one does not end the others."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="Fuzz the readers of outside data.")
    parser.add_argument("names", nargs="*", help="harnesses; all when none is named")
    parser.add_argument("--time", type=int, default=60, help="seconds for each (default 60)")
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.one:
        _fuzz(given.names[0], given.time)
    known = harnesses()
    if unknown := [name for name in given.names if name not in known]:
        parser.error(f"no harness {unknown[0]!r}; choose from {', '.join(known)}")
    failed = []
    for name in given.names or known:
        (BUILD / name / "found").mkdir(parents=True, exist_ok=True)
        command = [sys.executable, "-m", "fuzz", "--one", "--time", str(given.time), name]
        with open(BUILD / name / "log", "wb") as log:
            done = subprocess.run(command, stdout=log, stderr=log, check=False)
        text = (BUILD / name / "log").read_text("utf-8", "replace")
        runs = [line.split()[-1] for line in text.splitlines() if line.startswith("stat::number_of_executed")] or ["no"]
        print(f"{name}: {runs[-1]} executions{', BROKEN: see ' + str(BUILD / name) if done.returncode else ''}")
        failed += [name] if done.returncode else []
    return 1 if failed else 0


def _fuzz(name: str, seconds: int) -> None:
    import random

    import atheris

    with atheris.instrument_imports(include=_INSTRUMENTED):
        for module in [module for module in sys.modules if module.split(".")[0] in ("limner", "fuzz")]:
            if module not in ("fuzz", "fuzz.__main__"):
                del sys.modules[module]
        from fuzz.contract import check
        from fuzz.mutate import mutated

        reader = harnesses()[name]

    def changed(data: bytes, most: int, seed: int) -> bytes:
        # Half of the time what knows the formats, half of the time what knows the coverage.
        chance = random.Random(seed)
        return mutated(data, chance, [])[:most] if seed % 2 else atheris.Mutate(data, most)

    folder = BUILD / name
    options = [
        f"-max_total_time={seconds}",
        "-timeout=30",
        "-rss_limit_mb=2048",
        "-max_len=20000",
        "-print_final_stats=1",
    ]
    places = [f"-artifact_prefix={folder}/", str(folder / "found"), str(CORPUS / name)]
    atheris.Setup([sys.argv[0], *options, *places], lambda data: check(reader, data) and None, custom_mutator=changed)
    atheris.Fuzz()


if __name__ == "__main__":
    sys.exit(main())
