"""Numbers of any kind go in, read-only arrays of a checked shape come out; equality by content for what holds them."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from limner.errors import BadInput

Floats = NDArray[np.float64]


def frozen_array(value: ArrayLike, dtype: Any, shape: tuple[int | None, ...], name: str) -> NDArray[Any]:
    """Copy ``value`` into a read-only array, or say what shape was expected.

    Args:
        value: anything numpy can read.
        dtype: of the result.
        shape: expected shape; ``None`` stands for any length.
        name: of the field, for the message.

    Raises:
        BadInput: the shape is another one, or a float is not finite.
    """
    try:
        if isinstance(value, np.ndarray) and value.dtype.kind not in "biufO":
            raise TypeError(f"values of type {value.dtype}")
        with np.errstate(over="raise", invalid="raise"):
            array = np.array(value, dtype=dtype)
    except (TypeError, ValueError, OverflowError, FloatingPointError) as error:
        raise BadInput(f"{name}: expected numbers of shape {_shape(shape)}, got something else ({error})") from error
    if array.ndim != len(shape) or any(want not in (None, got) for want, got in zip(shape, array.shape, strict=True)):
        raise BadInput(f"{name}: expected shape {_shape(shape)}, got {_shape(array.shape)}")
    if array.dtype.kind == "f" and not np.isfinite(array).all():
        raise BadInput(f"{name}: expected finite numbers, got NaN or infinity")
    array.setflags(write=False)
    return array


def _shape(shape: Sequence[int | None]) -> str:
    return "(" + ", ".join("n" if n is None else str(n) for n in shape) + ("," if len(shape) == 1 else "") + ")"


@dataclasses.dataclass(frozen=True, eq=False)
class Value:
    """A dataclass that is equal to another by content; its fields may hold arrays."""

    def __eq__(self, other: object) -> bool:
        if type(other) is not type(self):
            return NotImplemented
        fields = dataclasses.fields(self)
        return all(same(getattr(self, f.name), getattr(other, f.name)) for f in fields)

    def _freeze(self, name: str, value: object) -> None:
        object.__setattr__(self, name, value)


def same(a: Any, b: Any) -> bool:
    """Whether two values have one content: ``Value``s, arrays, tuples, anything with ==."""
    if a is b:
        return True
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return type(a) is type(b) and bool(np.array_equal(a, b))
    if isinstance(a, tuple) and isinstance(b, tuple):
        return len(a) == len(b) and all(map(same, a, b))
    return bool(a == b)
