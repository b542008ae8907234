"""What a device is, and how it is spoken to. Part of halftone-kit.

``from devices import open_device`` loads no transport and no language until one is used.
"""

from __future__ import annotations

from typing import Any

__halftone__ = True
"""Marks this package as ours: ``devices`` is a common name."""

_PUBLIC = {
    "Device": "devices.device",
    "FrameBuffer": "devices.framebuffer",
    "LinuxFrameBuffer": "devices.fbdev",
    "Paper": "devices.paper",
    "DeviceProfile": "devices.profile",
    "Patience": "devices.sending",
    "Preview": "devices.preview",
    "PrintReport": "devices.device",
    "Status": "devices.status",
    "decode": "devices.decoding",
    "load": "devices.profile",
    "open_device": "devices.registry",
}

__all__ = [*_PUBLIC]  # pyright: ignore


def __getattr__(name: str) -> Any:
    if name not in _PUBLIC:
        raise AttributeError(f"module 'devices' has no attribute '{name}'")
    from importlib import import_module

    value = getattr(import_module(_PUBLIC[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return sorted({*globals(), *_PUBLIC})
