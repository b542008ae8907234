"""Working memory of threads."""

from __future__ import annotations

import threading
from typing import Any

import numpy as np
from numpy.typing import NDArray

__all__ = ["Scratch"]


class Scratch(threading.local):
    """Memory of one thread, kept from band to band: fresh pages cost more than writing to them."""

    def __init__(self) -> None:
        self.held: dict[str, NDArray[Any]] = {}

    def take(self, name: str, shape: tuple[int, ...], kind: Any = np.float32) -> NDArray[Any]:
        """An array of *shape* with any content, until *name* is taken again."""
        size = int(np.prod(shape))
        held = self.held.get(name)
        if held is None or held.size < size:
            held = self.held[name] = np.empty(max(size, 1), kind)
        return held[:size].reshape(shape)
