"""Compiled kernels: the only place that touches numba, and only when nothing is cached.

``@kernel("f4[:,:]; i8")`` marks a plain function over C-contiguous arrays and scalars that returns
nothing. At its first call it is compiled by numba for this one signature and machine, and the
object code is kept in the user's cache folder. A later process loads that object code with
llvmlite alone: numba's import and its first dispatch, which cost more than a picture, are left out.

The object is called with the argument list of numba's own calling convention (return slot,
exception slot, then every array as meminfo, parent, item count, item size, data, shape, strides).
It is used only if the types of the compiled function agree with that list and if it needs nothing
but the C library; otherwise, and whenever the cache cannot be read or written, numba's dispatcher
is called. A damaged, foreign or outdated file is compiled anew.
"""

from __future__ import annotations

import gc
import os
import threading
from collections.abc import Callable
from typing import Any

__all__ = ["TYPES", "Kernel", "kernel", "kernels", "part"]

TYPES = {
    "u1": ("uint8", "i8"),
    "i2": ("int16", "i16"),
    "i4": ("int32", "i32"),
    "i8": ("int64", "i64"),
    "f4": ("float32", "float"),
    "f8": ("float64", "double"),
}
"""Element types of a signature: NumPy's and numba's name, and LLVM's."""
_REGISTRY: list[Kernel] = []
_PARTS: list[Callable[..., Any]] = []
_LOCK = threading.Lock()


def kernel(signature: str, *, lanes: bool = False) -> Callable[[Callable[..., None]], Kernel]:
    """Mark a function as a kernel with one *signature*: u1, i2, i4, i8, f4, f8 and their arrays.

    lanes : whether it is written in the vectors of :mod:`halftone._lanes`.
    """

    def mark(function: Callable[..., None]) -> Kernel:
        made = Kernel(function, tuple(part.strip() for part in signature.split(";")), lanes)
        _REGISTRY.append(made)
        return made

    return mark


def part(function: Callable[..., Any]) -> Callable[..., Any]:
    """Mark a function that kernels of the same file call."""
    _PARTS.append(function)
    return function


def kernels() -> tuple[Kernel, ...]:
    """All kernels of the modules imported so far."""
    return tuple(_REGISTRY)


class Kernel:
    """A function that is compiled when it is first called. ``python`` is the plain function."""

    def __init__(
        self, function: Callable[..., None], signature: tuple[str, ...], lanes: bool = False
    ) -> None:
        self.python = function
        self.signature = signature
        self.lanes = lanes
        self.__name__ = function.__name__
        self.__doc__ = function.__doc__
        self._call: Callable[..., None] | None = None
        self.origin = "not loaded"  # then: cache, compiled, numba or python

    def __call__(self, *arguments: Any) -> None:
        if self._call is None:
            self.prepare()
        self._call(*arguments)  # type: ignore[misc]

    def prepare(self) -> str:
        """Load or compile, without a call; returns where the code came from."""
        with _LOCK:
            if self._call is None:
                self._call = self._load()
        return self.origin

    def _load(self) -> Callable[..., None]:
        if os.environ.get("NUMBA_DISABLE_JIT", "0") not in ("", "0"):
            self.origin = "python"
            return self.python
        from halftone import _objects

        found = _objects.read(self)
        if found is not None:
            self.origin = "cache"
            return _objects.caller(self, found)
        collecting = gc.isenabled()
        gc.disable()  # numba makes so many objects that looking after them takes a fifth of the time
        try:
            dispatcher, object_code = self.compile()
        finally:
            if collecting:
                gc.enable()
        if object_code is None:
            self.origin = "numba"
            return dispatcher
        self.origin = "compiled"
        _objects.write(self, object_code)
        return _objects.caller(self, object_code)

    def compile(self) -> tuple[Callable[..., None], bytes | None]:
        """numba's dispatcher, and the object code if it can be used without numba."""
        import numba
        import numba.extending
        from numba.core import types

        if self.lanes:
            from halftone._lanes_ir import register

            register()
        while _PARTS:
            numba.extending.register_jitable(_PARTS.pop())
        spec = []
        for part in self.signature:
            base = getattr(types, TYPES[part[:2]][0])
            spec.append(types.Array(base, part.count(":"), "C") if "[" in part else base)
        options = {"nogil": True, "error_model": "numpy", "_nrt": False}
        dispatcher = numba.njit(tuple(spec), no_cpython_wrapper=True, no_cfunc_wrapper=True, **options)(
            self.python
        )
        from halftone import _objects

        object_code = _objects.build(self, dispatcher.inspect_llvm(tuple(spec)))
        if object_code is None:  # typed at each call: arrays that may not be written are a type
            dispatcher = numba.njit(**options)(self.python)
        return dispatcher, object_code

    def flat(self) -> list[str]:
        """LLVM types of the compiled function's arguments, as numba lays them out."""
        types = ["ptr", "ptr"]
        for part in self.signature:
            if "[" in part:
                types += ["ptr", "ptr", "i64", "i64", "ptr"] + ["i64"] * (2 * part.count(":"))
            else:
                types.append(TYPES[part][1])
        return types
