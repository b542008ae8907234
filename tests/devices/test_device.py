"""Printing: every byte once, every failure named within its deadline, every break-off completed."""

from __future__ import annotations

from pathlib import Path

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
from devices.languages.escpos import EscPos
from devices.languages.pbm import Pbm
from halftone.errors import InputFileError, OutputError, UsageError
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
            silent += 0.0 if stops else step.seconds  # a short stop may pass unseen
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
        (frame_of(picture(2)), {"density": 3.5}, "an integer"),
        (np.zeros((2, 2)), {"methud": "fs"}, "Did you mean method"),
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


def test_nothing_and_the_same_bands_twice():
    with open_device("pbm+mem:", "generic-1bit") as made:
        bands = frame_of(picture(2)).bands()
        for pictures, word in (((), "nothing to print"), ((bands, bands), "given twice")):
            with pytest.raises(UsageError, match=word):
                made.print(*pictures)
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


def asking() -> EscPos:
    return EscPos(feed=0)


def test_no_paper_that_is_said_once_holds_until_the_device_says_that_it_is_mended():
    """ESC/POS's automatic status comes once; the deadline is then that of a fault, not of silence."""
    empty, well = bytes([0x10, 0, 0x0C, 0]), bytes([0x10, 0, 0, 0])
    script = [Take(1 << 20), Say(b"\x12\x12\x12\x12"), Take(40), Say(empty[:2]), Hold(2), Say(empty[2:])]
    told = []
    made, _, _ = device([*script, Hold(70), Say(well), Hold(5)], asking())
    report = made.print(frame_of(picture(200)), notify=told.append)
    assert [str(status) for status in told][-2:] == ["no paper", "ready"]
    assert report.completed
    assert report.waited > 60
    assert len(told) == 2


def test_the_question_is_not_put_to_a_device_that_takes_nothing():
    made, transport, clock = device([], asking())
    transport.until, transport.reasons = 1e9, ("media-empty-error",)
    assert made.status() == Status.of("media-empty-error")
    assert (clock.now, transport.got) == (0, b"")


def test_a_cancel_is_heard_while_the_device_takes_nothing():
    made, _, clock = device([Hold(1e9)], asking())
    report = made.print(frame_of(picture(5)), cancel=lambda: clock.now > 5)
    assert (report.cancelled, report.bytes_accepted) == (True, 0)
    assert clock.now < 10


def test_silence_after_no_paper_does_not_say_that_it_is_mended():
    class Answers(Scripted):
        def write(self, data, timeout):
            if not self.got:
                self.waiting = b"\x12\x12\x12\x72"  # to the first question, and to no more
            return super().write(data, timeout) if self.got else len(self.got.__iadd__(data))

    clock = Clock()
    made = Device(
        Answers([], clock), asking(), PROFILE, patience=PATIENCE, clock=clock, asleep=clock.sleep
    )
    with pytest.raises(DeviceStateError) as caught:
        made.print(frame_of(picture(5)))
    assert caught.value.reasons == {"media-empty-error"}
    assert clock.now == pytest.approx(PATIENCE.fault, abs=10)


def test_a_broken_transport_is_not_written_to_again():
    class Full(Scripted):
        def write(self, data, timeout):
            if self.got:
                self.dead = True
                raise OutputError("the disk is full")
            return super().write(data[:100], timeout)

    clock = Clock()
    made = Device(Full([], clock), Pbm(), PROFILE, patience=PATIENCE, clock=clock, asleep=clock.sleep)
    with pytest.raises(OutputError):
        made.print(frame_of(picture(50)))
    assert (made.report.bytes_accepted, made.report.completed) == (100, False)


def test_the_page_before_a_bad_one_is_printed_whole():
    def bad():
        raise InputFileError("no picture")

    for language, name in (("brother-ql", "brother-ql-62mm"), ("dymo", "dymo-lw-450")):
        with open_device(f"{language}+mem:", name) as made:
            with pytest.raises(InputFileError):
                made.print(frame_of(picture(400), dpi=(300.0, 300.0)), bad)
            (shown,) = made.language.decode(made.transport.data)
        np.testing.assert_array_equal(shown.indices[:, :61], picture(400))
        assert made.report.pages_accepted == 1


def test_what_cannot_be_patience():
    for name, value in (
        ("stall", float("nan")),
        ("fault", -1),
        ("answer", float("inf")),
        ("finish", "3"),
    ):
        with pytest.raises(UsageError, match=name):
            Patience(**{name: value})


def test_a_closed_device():
    made = open_device("pbm+mem:", "generic-1bit")
    made.close()
    for call in (made.status, lambda: made.print(frame_of(picture(3)))):
        with pytest.raises(UsageError, match="closed"):
            call()


def test_an_empty_file_stays_away(tmp_path):
    """What is opened and not printed to leaves the file that was there."""
    path = tmp_path / "keep.bin"
    path.write_bytes(b"precious")
    with open_device(f"pbm+file:{path}", "generic-1bit"):
        pass
    with pytest.raises(UsageError), open_device(f"pbm+file:{path}", "generic-1bit") as made:
        made.print(frame_of(picture(3)), density=5)
    assert path.read_bytes() == b"precious"
    assert list(tmp_path.iterdir()) == [path]


def test_files_are_closed_when_printing_fails(tmp_path):
    """Also while the error is still looked at."""
    frame_of(picture(3000, 600)).save(tmp_path / "in.pbm")
    made, _, _ = device([Take(100), Gone()])
    before = len(list(Path("/proc/self/fd").iterdir()))
    with pytest.raises(DisconnectedError):
        made.print(tmp_path / "in.pbm")
    assert len(list(Path("/proc/self/fd").iterdir())) == before
