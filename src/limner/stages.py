"""A stage and its inputs go in; its result comes out, from memory where the inputs are those of the last time."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Any, TypeVar, TypeVarTuple

from limner.types import same

Inputs = TypeVarTuple("Inputs")
Result = TypeVar("Result")


class Stages:
    """Runs stages and keeps what they gave, so that a changed setting costs only what follows it.

    A stage is a function whose result depends on its inputs alone. Inputs are compared by identity, then by content:
    where a stage was done again and came out the same, what follows it is not done again.
    """

    def __init__(self, keep: int = 1, before: Callable[[], None] = lambda: None) -> None:
        """Remember nothing yet.

        Args:
            keep: how many results of each stage are held, the latest; bounds the memory.
            before: called before each stage; what it raises ends the work there.
        """
        self._keep = keep
        self._before = before
        self._kept: dict[str, list[tuple[Any, Any]]] = {}
        self._seconds: dict[str, float] = {}

    def __call__(self, name: str, run: Callable[[*Inputs], Result], *inputs: *Inputs) -> Result:
        """What ``run`` gives for the inputs, or gave for them before.

        Args:
            name: of the stage; its results share one memory.
            run: the stage.
            *inputs: all that the result depends on.
        """
        self._before()
        start = time.perf_counter()
        key = (run, inputs)
        kept = self._kept.setdefault(name, [])
        found = next((entry for entry in kept if same(entry[0], key)), None)
        if found:
            kept.remove(found)
        else:
            found = key, run(*inputs)
        kept.insert(0, found)
        del kept[self._keep :]
        self._seconds[name] = self._seconds.get(name, 0.0) + time.perf_counter() - start
        result: Result = found[1]
        return result

    def take_seconds(self) -> dict[str, float]:
        """Seconds spent in each stage since they were last taken; next to none where its result was kept."""
        seconds, self._seconds = self._seconds, {}
        return seconds
