"""Printing: every byte once, every failure named within its deadline, every break-off completed."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from devices import Patience, Status, load, open_device
from devices.device import Device
from devices.errors import (
    DeviceStateError,
    DeviceTimeoutError,
    DisconnectedError,
    PrintError,
    StalledError,
)
from devices.languages.base import encoded
from devices.languages.pbm import Pbm
from halftone.errors import InputFileError, UsageError
from tests.devices.languages.contract import frame_of
from tests.devices.simulated import Clock, Gone, Hold, Say, Scripted, Stall, Take

PROFILE = load("generic-1bit")
PATIENCE = Patience(stall=20.0, fault=100.0, answer=3.0, finish=10.0)
REASONS = ("media-empty-error", "cover-open-error", "media-low-warning")

steps = st.one_of(
    st.builds(Take, st.integers(1, 600), st.floats(0, 5)),
    st.builds(Hold, st.floats(0, 15)),
    st.builds(Hold, st.floats(0, 60), st.lists(st.sampled_from(REASONS), min_size=1).map(tuple)),
    st.builds(Say, st.binary(min_size=1, max_size=9)),
)
endings = st.sampled_from([None, None, Gone(), Stall(), Hold(1e9), Hold(1e9, ("media-empty-error",))])


def picture(rows: int, width: int = 61) -> np.ndarray:
    return np.random.default_rng(rows).integers(0, 2, (rows, width)).astype(np.uint8)


def device(script, language=None, **more) -> tuple[Device, Scripted, Clock]:
    clock = Clock()
    transport = Scripted(list(script), clock)
    made = Device(
        transport, language or Pbm(), PROFILE, patience=PATIENCE, clock=clock, asleep=clock.sleep, **more
    )
    return made, transport, clock


def expected(script, ending) -> set[type[PrintError]]:
    """The errors that a script may end in: of its ending, or of holds that add up."""
    kinds: set[type[PrintError]] = set()
    silent = named = 0.0
    for step in [*script, ending]:
        if isinstance(step, Take):
            silent = named = 0.0
        elif isinstance(step, Say):
            silent += 0.6
        elif isinstance(step, Hold):
            stops = any(reason.endswith("-error") for reason in step.reasons)
            silent = 0.0 if stops else silent + step.seconds
            named += step.seconds if stops else 0.0
        if silent >= PATIENCE.stall - 1:
            kinds.add(DeviceTimeoutError)
        if named >= PATIENCE.fault - 1:
            kinds.add(DeviceStateError)
    if isinstance(ending, Gone | Stall):
        kinds.add(DisconnectedError if isinstance(ending, Gone) else StalledError)
    return kinds


@settings(max_examples=400)
@given(st.lists(steps, max_size=12), endings, st.integers(1, 300))
def test_every_byte_once_or_a_named_error_in_time(script, ending, rows):
    made, transport, clock = device([*script, *([] if ending is None else [ending])])
    frame = frame_of(picture(rows))
    whole = encoded(Pbm(), frame)
    error = None
    try:
        report = made.print(frame)
    except PrintError as caught:
        error, report = caught, caught.report
    assert whole.startswith(bytes(transport.got)), "a byte was lost or sent twice"
    assert report.bytes_accepted == len(transport.got)
    if error is None:
        assert (bytes(transport.got), report.completed) == (whole, True)
        assert (report.rows_accepted, report.pages_accepted) == (rows, 1)
    else:
        assert type(error) in expected(script, ending)
        assert not report.completed
        head = len(f"P4\n61 {rows}\n")
        assert report.rows_accepted == max(0, len(transport.got) - head) // 8
    given_up = sum(s.seconds for s in script if not isinstance(s, Say)) + 120 + len(script)
    assert clock.now <= given_up, "a failure came after its deadline"


quick = st.one_of(  # less than Patience.finish in all
    st.builds(Take, st.integers(1, 600), st.floats(0, 0.3)),
    st.builds(Hold, st.floats(0, 0.6)),
    st.builds(Say, st.binary(min_size=1, max_size=9)),
)


@given(st.lists(quick, max_size=12), st.integers(1, 40), st.integers(1, 300))
def test_a_cancel_completes_the_open_command(script, after, rows):
    made, transport, _ = device(script)
    asked = iter(range(10**9))
    report = made.print(frame_of(picture(rows)), cancel=lambda: next(asked) >= after)
    if not report.cancelled:
        assert bytes(transport.got) == encoded(Pbm(), frame_of(picture(rows)))
        return
    assert report.completed
    if transport.got:
        (shown,) = Pbm.decode(bytes(transport.got))
        accepted = report.rows_accepted
        np.testing.assert_array_equal(shown.indices[:accepted], picture(rows)[:accepted])


def test_paper_out_waits_and_goes_on():
    told = []
    made, transport, clock = device([Take(100), Hold(90, ("media-empty-error",)), Take(50)])
    report = made.print(frame_of(picture(200)), notify=told.append)
    assert bytes(transport.got) == encoded(Pbm(), frame_of(picture(200)))
    assert report.reasons == {"media-empty-error"}
    assert report.waited == pytest.approx(90, abs=1)
    assert told == [Status.of("media-empty-error"), Status()]
    assert clock.now >= 90


def test_a_page_that_fails_on_the_way_leaves_a_complete_command():
    def rows():
        yield picture(30)[:20]
        raise InputFileError("the file ends in its middle")

    made, transport, _ = device([])
    bands = frame_of(picture(30)).bands()
    object.__setattr__(bands, "indices", rows())
    with pytest.raises(InputFileError, match="middle"):
        made.print(frame_of(picture(8)), bands)
    first, _ = Pbm.decode(bytes(transport.got) + encoded(Pbm(), frame_of(picture(3))))
    np.testing.assert_array_equal(first.indices, picture(8))


@pytest.mark.parametrize(
    ("frame", "options", "word"),
    [
        (frame_of(picture(2, 577)), {}, "577 dots wide and 'receipt-80mm' has 576"),
        (frame_of(picture(2), levels=4), {}, "4 levels"),
        (frame_of(picture(2)), {"copies": 0}, "copies"),
        (frame_of(picture(2)), {"density": 3}, "no density"),
        (frame_of(picture(2)), {"cut": True}, "no command for it"),
        (frame_of(picture(2)), {"method": "fs"}, "halftoned already"),
        (frame_of(picture(2)).bands(), {"copies": 2}, "read once"),
    ],
)
def test_what_cannot_be_is_refused_before_a_byte_is_sent(frame, options, word):
    with open_device("pbm+mem:", "receipt-80mm") as made:
        with pytest.raises(UsageError, match=word):
            made.print(frame, **options)
        assert made.transport.data == b""


def test_copies_without_a_command_for_them():
    with open_device("pbm+mem:", "generic-1bit") as made:
        report = made.print(frame_of(picture(5)), copies=3)
    assert (report.pages, report.pages_accepted, report.rows_accepted) == (3, 3, 15)
    assert made.transport.data == encoded(Pbm(), frame_of(picture(5))) * 3


def test_a_picture_is_halftoned_for_the_device(photograph):
    with open_device("pbm+mem:", "receipt-80mm") as made:
        report = made.print(photograph, method="stucki")
    (shown,) = Pbm.decode(made.transport.data)
    assert shown.shape == (383, 576)
    assert report.rows_accepted == 383
    assert 0.2 < shown.indices.mean() < 0.8
    assert "scaled" in report.pictures[0]["notes"][0]
