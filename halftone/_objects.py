"""Object code of compiled kernels: built with llvmlite, kept in the user's cache, called by ctypes.

A cache file is ``MAGIC + sha256(payload) + payload``. Its name holds a hash of the kernel's source
file, its signature, the versions of numba and of LLVM and the processor, so that an outdated file
is never asked for. Only files that belong to this user are loaded: they are executed.
"""

from __future__ import annotations

import ctypes
import hashlib
import os
import sys
import tempfile
import weakref
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from halftone._jit import Kernel

__all__ = ["build", "caller", "clear", "directory", "files", "read", "write"]

_MAGIC = b"halftone-kernel-1\n"
_SUFFIX = ".kernel"
_ENTRY = "halftone_kernel"
_LIBC = {"memset", "memcpy", "memmove"}
_RETURNED = (0, -2)  # numba's status for "returned a value" and "returned None"
_CTYPES = {
    "ptr": ctypes.c_void_p,
    "i8": ctypes.c_uint8,
    "i16": ctypes.c_int16,
    "i32": ctypes.c_int32,
    "i64": ctypes.c_int64,
    "float": ctypes.c_float,
    "double": ctypes.c_double,
}
MOST_LAYOUTS = 512
_layouts: dict[int, tuple[Callable[[], Any], tuple[Any, ...]]] = {}
_engines: list[Any] = []  # an engine owns the machine code of its kernels: never collected


def directory() -> Path:
    """Folder of the cache: $HALFTONE_CACHE_DIR, or halftone in the user's cache folder."""
    chosen = os.environ.get("HALFTONE_CACHE_DIR")
    if chosen:
        return Path(chosen)
    base = os.environ.get("XDG_CACHE_HOME")
    return (Path(base) if base else Path.home() / ".cache") / "halftone"


def files(suffix: str = _SUFFIX) -> list[Path]:
    """All cached kernels, of this and of other versions; or what else is kept, by its *suffix*."""
    try:
        return sorted(directory().glob("*" + suffix))
    except OSError:
        return []


def clear() -> int:
    """Delete all cached kernels, and print curves; returns how many kernels there were."""
    found = files()
    for path in [*found, *files(".curve")]:
        path.unlink(missing_ok=True)
    return len(found)


def read(kernel: Kernel) -> bytes | None:
    """The cached object code of *kernel*, or None if it is missing, foreign or damaged."""
    try:
        path = _path(kernel)
        with open(path, "rb") as file:
            if os.fstat(file.fileno()).st_uid not in (os.geteuid(), 0):
                return None
            blob = file.read()
    except (OSError, RuntimeError):  # RuntimeError: a user without a home folder
        return None
    head = len(_MAGIC) + 32
    payload = blob[head:]
    if blob[:head] != _MAGIC + hashlib.sha256(payload).digest():
        return None
    return payload


def write(kernel: Kernel, object_code: bytes) -> bool:
    """Keep *object_code*; False where the cache cannot be written, which is no error."""
    temporary = None
    try:
        path = _path(kernel)
        path.parent.mkdir(parents=True, exist_ok=True, mode=0o700)
        handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=_SUFFIX)
        with os.fdopen(handle, "wb") as file:
            file.write(_MAGIC + hashlib.sha256(object_code).digest() + object_code)
        os.replace(temporary, path)
    except (OSError, RuntimeError):
        if temporary:
            Path(temporary).unlink(missing_ok=True)
        return False
    return True


def build(kernel: Kernel, ir: str) -> bytes | None:
    """Native object code for the LLVM *ir* of a kernel; None if numba would be needed to run it."""
    llvm = _llvm()
    module = llvm.parse_assembly(ir)
    entries = []
    for function in module.functions:
        if function.is_declaration:
            if not function.name.startswith("llvm.") and function.name not in _LIBC:
                return None
        elif [str(a.type) for a in function.arguments] == kernel.flat():
            entries.append(function)
    if len(entries) != 1:
        return None
    entries[0].name = _ENTRY
    entries[0].linkage = "external"
    return bytes(_machine(llvm).emit_object(module))


def caller(kernel: Kernel, object_code: bytes) -> Callable[..., None]:
    """A function that runs *object_code* on NumPy arrays and scalars, without the GIL."""
    llvm = _llvm()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), _machine(llvm))
    engine.add_object_file(llvm.ObjectFileRef.from_data(object_code))
    engine.finalize_object()
    address = engine.get_function_address(_ENTRY)
    _engines.append(engine)
    from halftone._jit import TYPES

    function = ctypes.CFUNCTYPE(ctypes.c_int32, *(_CTYPES[name] for name in kernel.flat()))(address)
    plan = [
        (part, part.count(":"), np.dtype(TYPES[part[:2]][0]) if "[" in part else None)
        for part in kernel.signature
    ]

    def call(*arguments: Any) -> None:
        returned, raised = ctypes.c_void_p(), ctypes.c_void_p()
        flat: list[Any] = [ctypes.addressof(returned), ctypes.addressof(raised)]
        for (part, dimensions, dtype), value in zip(plan, arguments, strict=True):
            if dtype is None:
                flat.append(value)
            elif value.dtype != dtype or value.ndim != dimensions or not value.flags.c_contiguous:
                raise TypeError(f"{kernel.__name__}: {part} wanted, {value.dtype}{value.shape} got")
            else:
                flat += _laid_out(value)
        status = function(*flat)
        if status not in _RETURNED:
            raise RuntimeError(f"kernel {kernel.__name__} failed with status {status}")

    return call


def _laid_out(array: Any) -> tuple[Any, ...]:
    """An array as numba passes it. Asking for its address costs a microsecond, so it is kept."""
    known = _layouts.get(id(array))
    if known is not None and known[0]() is array:
        return known[1]
    layout = (
        None, None, array.size, array.itemsize, array.ctypes.data, *array.shape, *array.strides
    )  # fmt: skip
    if len(_layouts) > MOST_LAYOUTS:
        _layouts.clear()
    _layouts[id(array)] = weakref.ref(array), layout
    return layout


def _llvm() -> Any:
    import llvmlite.binding as llvm

    if not _engines:
        for start in ("initialize_native_target", "initialize_native_asmprinter"):
            # llvmlite initialises LLVM's core by itself; these two stay explicit.
            getattr(llvm, start)()
    return llvm


def _processor(llvm: Any) -> tuple[str, str]:
    """Name and features of the processor compiled for; numba's own variables are honoured."""
    name = os.environ.get("NUMBA_CPU_NAME")
    features = os.environ.get("NUMBA_CPU_FEATURES")
    if name is None:
        name = llvm.get_host_cpu_name()
        if features is None:
            features = llvm.get_host_cpu_features().flatten()
    return name, features or ""


def _machine(llvm: Any) -> Any:
    name, features = _processor(llvm)
    target = llvm.Target.from_triple(llvm.get_process_triple())
    return target.create_target_machine(
        cpu=name, features=features, opt=3, reloc="default", codemodel="jitdefault", jit=True
    )


def _path(kernel: Kernel) -> Path:
    llvm = _llvm()
    numba = find_spec("numba")
    version = Path(str(numba.origin)).with_name("_version.py").read_bytes() if numba else b""
    sources = [Path(kernel.python.__code__.co_filename)]
    if kernel.lanes:
        sources += [Path(__file__).with_name(name) for name in ("_lanes.py", "_lanes_ir.py")]
    parts = [
        *(source.read_bytes() for source in sources),
        kernel.__name__.encode(),
        ";".join(kernel.signature).encode(),
        hashlib.sha256(version).digest(),
        llvm.llvm_version_info.__repr__().encode(),
        repr(_processor(llvm)).encode(),
        sys.platform.encode(),
    ]
    key = hashlib.sha256(b"\0".join(hashlib.sha256(part).digest() for part in parts))
    return directory() / f"{kernel.__name__}-{key.hexdigest()[:20]}{_SUFFIX}"
