"""A harness and a bound go in; it runs over its corpus and changes of it, and what it breaks on comes out."""

from __future__ import annotations

import random
import time
import traceback
import zlib
from dataclasses import dataclass, field

from fuzz import corpus, harnesses
from fuzz.contract import check
from fuzz.mutate import mutated


@dataclass
class Outcome:
    """What became of a run.

    Attributes:
        name: of the harness.
        executions: how often it ran.
        accepted: how often bytes were read as a value.
        broken: inputs that break the promise, each with the end of its traceback, one for each place in the code.
        cpu_s: that all took.
    """

    name: str
    executions: int = 0
    accepted: int = 0
    broken: dict[str, tuple[bytes, str]] = field(default_factory=dict)
    cpu_s: float = 0.0


def run(name: str, executions: int, seed: int = 0, cpu_s: float = float("inf")) -> Outcome:
    """Run a harness over its corpus, then over changes of it: the same each time for the same seed.

    Args:
        name: of the harness.
        executions: how many changed inputs.
        seed: of the changes.
        cpu_s: of the processor after which it ends early, after the corpus and one changed input at the earliest.
    """
    reader, inputs, outcome = harnesses()[name], corpus(name), Outcome(name)
    chance, began = random.Random(zlib.crc32(name.encode()) + seed), time.process_time()
    for k in range(len(inputs) + executions):
        if k > len(inputs) and time.process_time() - began > cpu_s:
            break
        data = inputs[k] if k < len(inputs) else mutated(chance.choice(inputs), chance, inputs)
        outcome.executions += 1
        try:
            outcome.accepted += check(reader, data)
        except Exception as error:  # whatever it is, it is a finding
            frames = traceback.extract_tb(error.__traceback__)
            ours = [frame for frame in frames if "/limner/" in frame.filename] or frames
            place = f"{type(error).__name__} {ours[-1].filename.rpartition('/src/')[2]}:{ours[-1].lineno}"
            outcome.broken.setdefault(place, (data, "".join(traceback.format_exception(error)[-6:])))
    outcome.cpu_s = time.process_time() - began
    return outcome
