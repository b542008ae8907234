"""The same simulated faults for our Device, python-escpos and brother_ql: tests/bench/usb_faults.py."""

from __future__ import annotations

from importlib.metadata import version

import pytest

pytest.importorskip("usb", reason="pyusb is not installed (tests/peers/install.sh)")
pytest.importorskip("escpos", reason="python-escpos is not installed (tests/peers/install.sh)")
pytest.importorskip("brother_ql", reason="brother_ql is not installed (tests/peers/install.sh)")

from tests.bench.usb_faults import CASES, DRIVERS, Ended, payload, picture, run

pytestmark = pytest.mark.peer

RIVALS = [name for name in DRIVERS if name != "ours"]


@pytest.fixture(scope="module")
def job():
    frame = picture()
    return frame, payload(frame)


@pytest.mark.parametrize("driver", DRIVERS)
def test_without_a_fault_all_of_them_deliver(job, driver):
    """Else the comparison would be none."""
    ended = run("no fault", driver, *job)
    assert ended.whole
    assert not ended.said


@pytest.mark.parametrize("case", CASES)
def test_ours_delivers_or_says_how_far_it_came(job, case):
    ended = run(case, "ours", *job)
    had = len(ended.printer.received)
    assert ended.payload.startswith(bytes(ended.printer.received))
    assert ended.whole != bool(ended.said)
    if ended.told is None:
        assert had == 0
        assert ended.said == "`DeviceBusyError`"
    elif case.startswith(("halts", "unplugged")):
        assert had - 8192 <= ended.told <= had
    else:
        assert ended.told == had
    assert not ended.printer.plugged or ended.printer.drivers == ended.driver


@pytest.mark.parametrize("case", CASES)
@pytest.mark.parametrize("driver", RIVALS)
def test_ours_delivers_wherever_another_does(job, case, driver):
    assert run(case, "ours", *job).whole or not run(case, driver, *job).whole


def test_what_the_table_says_of_the_others(job):
    """Measured with these versions; a newer one may have been mended."""
    if (version("python-escpos"), version("brother_ql")) != ("3.1", "0.9.4"):
        pytest.skip("the table was written for python-escpos 3.1 and brother_ql 0.9.4")

    def silent(ended: Ended) -> bool:
        return not ended.whole and not ended.said

    for driver in RIVALS:
        assert silent(run("takes 12,000 bytes, and says so", driver, *job))
    assert silent(run("out of paper for 30 s after 12,000 bytes", "brother_ql", *job))
    ended = run("takes nothing while 12 bytes of status wait to be read", "python-escpos", *job)
    assert ended.said == "**waits for ever**"
    ended = run("`usblp` has it", "python-escpos", *job)
    assert ended.printer.drivers == {}
    assert "reset" in str(ended)
