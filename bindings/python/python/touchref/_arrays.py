"""What is passed as arrays, and what is returned as such."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Optional

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ._errors import invalid


def numbers(values: ArrayLike, key: str, shape: tuple[Optional[int], ...], expected: str) -> NDArray[np.float64]:
    """Numbers of double precision in this shape; ``None`` stands for any length."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError) as error:
        raise invalid(f"{key}: {error}", key, f"expected {expected}") from error
    if array.dtype.kind not in "fiu":
        raise invalid(f"{key} has dtype {array.dtype}; expected {expected}", key, "give numbers")
    if np.ma.is_masked(values):
        raise invalid(f"{key} is masked in places; expected {expected}", key, "leave out what is not known")
    if array.ndim != len(shape) or any(n not in (None, m) for n, m in zip(shape, array.shape)):
        raise invalid(f"{key} has shape {array.shape}; expected {expected}", key)
    return array.astype(np.float64)


def texts(values: Any, key: str, count: int, of: str) -> list[str]:
    """So many texts."""
    if isinstance(values, str) or not hasattr(values, "__iter__"):
        raise invalid(f"{key} is {values!r}; expected a list of {of}, one a touch", key)
    listed = list(values)
    for index, value in enumerate(listed):
        if not isinstance(value, str):
            raise invalid(f"{key}[{index}] is {value!r}; expected a text: {of}", key)
    if len(listed) != count:
        raise invalid(f"there are {count} touches, but {len(listed)} {key}; expected one a touch", key)
    return [str(value) for value in listed]


def frozen(values: Sequence[Any]) -> NDArray[np.float64]:
    """An array that nobody changes."""
    array = np.array(values, dtype=np.float64)
    array.flags.writeable = False
    return array
