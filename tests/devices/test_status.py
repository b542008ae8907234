"""States in IPP's words."""

from __future__ import annotations

import pytest

from devices import Status
from devices.status import KEYWORDS
from halftone.errors import UsageError


def test_words_and_severity():
    status = Status.of("cover-open-error") | Status.of("media-low-warning")
    assert status.stopped
    assert str(status) == "the cover is open, paper is running out"
    assert not Status.of("media-empty-warning", "offline-report").stopped
    assert (str(Status()), Status().stopped) == ("ready", False)


def test_every_keyword_with_every_severity():
    for keyword in KEYWORDS:
        for severity in ("error", "warning", "report"):
            assert Status.of(f"{keyword}-{severity}").stopped == (severity == "error")


@pytest.mark.parametrize("reason", ["media-empty", "error", "on-fire-error", "media-empty-fatal", ""])
def test_no_other_words(reason):
    with pytest.raises(UsageError, match="IPP state reason"):
        Status.of(reason)
