"""From the words of a user to an open device."""

from __future__ import annotations

from typing import Any

from devices.device import Device
from devices.languages import language as make_language
from devices.languages.base import Language
from devices.profile import DeviceProfile, load
from devices.sending import Patience
from devices.transports import open_transport
from devices.transports.base import Uri
from halftone.errors import UsageError

__all__ = ["language_for", "open_device"]


def open_device(
    uri: str,
    device: str | DeviceProfile | None = None,
    *,
    options: dict[str, Any] | None = None,
    patience: Patience | None = None,
    timeout: float = 10.0,
) -> Device:
    """Open the device at *uri*.

    uri : where it is, as CUPS writes it, with its language in front if the profile does not say it:
    ``escpos+usb://04b8:0202``, ``usb://EPSON/TM-T20?serial=SN1``, ``zpl+socket://192.168.1.9``,
    ``file:/dev/usb/lp0``, ``serial:/dev/ttyS0?baud=115200``, ``mem:``.
    device : a profile or its name. options : of the language, over those of the profile.
    patience : how long it may take; timeout : seconds to open it.

    Raises UsageError, DeviceNotFoundError, and the errors of :mod:`devices.errors`.
    """
    place = Uri.parse(uri)
    if device is None:
        raise UsageError(f"which device is at '{uri}'? Name its profile (halftone list devices)")
    profile = device if isinstance(device, DeviceProfile) else load(device)
    language = language_for(profile, place.language, options)
    return Device(open_transport(place, timeout), language, profile, uri=uri, patience=patience)


def language_for(
    profile: DeviceProfile, name: str | None = None, options: dict[str, Any] | None = None
) -> Language:
    """The language *name*, or the profile's, with the profile's options if they are for it."""
    chosen = name or profile.language
    if chosen is None:
        raise UsageError(
            f"'{profile.name}' names no language; put one in front of the URI, as escpos+usb://…"
        )
    own = profile.options if chosen == profile.language else {}
    try:
        make_language(chosen, **own).packing(profile.levels)
    except UsageError as error:
        raise UsageError(f"'{profile.name}' with the language '{chosen}': {error}") from None
    return make_language(chosen, **{**own, **(options or {})})
