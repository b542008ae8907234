"""Bytes that were sent to a device, back to what they show."""

from __future__ import annotations

from devices.languages import detect, language_type
from devices.languages.base import LIMIT
from halftone.errors import InputFileError
from halftone.frame import Frame

__all__ = ["decode"]


def decode(data: bytes, language: str | None = None, *, limit: int = LIMIT) -> list[Frame]:
    """The pages in *data*, as frames of level indices.

    language : its name; None finds it by the first bytes. limit : pixels of all pages; more are
    refused before they are made.

    Raises InputFileError if it is in no language we read, and its kin
    :class:`devices.errors.ProtocolError` with the offset of what the language does not allow.
    """
    if not data:
        raise InputFileError("the stream is empty")
    return language_type(language or detect(data)).decode(data, limit)
