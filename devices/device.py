"""A device: a profile, a language and a transport; pictures go in, a report comes out."""

from __future__ import annotations

import time
from collections.abc import Callable, Generator
from dataclasses import dataclass, field, fields
from types import TracebackType
from typing import Any, Self

from devices.errors import PrintError
from devices.languages.base import Language, Page, Piece, page_of
from devices.profile import DeviceProfile
from devices.sending import Cancelled, Patience, Sender
from devices.status import Status
from devices.transports.base import Transport
from halftone.errors import HalftoneError, UsageError, near
from halftone.frame import Bands, Frame

__all__ = ["Device", "PrintReport"]


@dataclass
class PrintReport:
    """How far a print came.

    rows : of all pages so far. rows_accepted : of which the device has all bytes; what it had on paper
    when it failed is for it to say. pages_accepted : whole pages. bytes_accepted : of everything.
    reasons : all that the device said on the way. waited : seconds it held the job up.
    cancelled : whether the user broke it off. completed : whether the language's last command was
    accepted: also after a cancel the device is then ready for the next job.
    """

    uri: str = ""
    device: str = ""
    language: str = ""
    pages: int = 0
    pages_accepted: int = 0
    rows: int = 0
    rows_accepted: int = 0
    bytes_accepted: int = 0
    seconds: float = 0.0
    waited: float = 0.0
    reasons: frozenset[str] = frozenset()
    cancelled: bool = False
    completed: bool = False
    pictures: list[dict[str, Any]] = field(default_factory=list)

    def __str__(self) -> str:
        rows = f"{self.rows_accepted} of {self.rows} rows"
        if self.cancelled:
            end = "" if self.completed else ", not the end of its command: switch it off and on"
            return f"cancelled: the device accepted {rows}{end}"
        if self.completed:
            pages = f"{self.pages} page{'s' * (self.pages != 1)}"
            return f"{pages}, {self.rows} rows, {self.bytes_accepted} bytes"
        return f"the device accepted {rows}, {self.bytes_accepted} bytes"


class Device:
    """An open device. ``with open_device(…) as device: device.print("photo.jpg")``.

    patience : how long it may take. record : called with all bytes that it accepts. report : of the
    last print, also of one that failed.
    """

    def __init__(
        self,
        transport: Transport,
        language: Language,
        profile: DeviceProfile,
        *,
        uri: str = "",
        patience: Patience | None = None,
        record: Callable[[bytes], None] | None = None,
        clock: Callable[[], float] = time.monotonic,
        asleep: Callable[[float], None] = time.sleep,
    ) -> None:
        self.transport, self.language, self.profile, self.uri = transport, language, profile, uri
        self.patience = patience or Patience()
        self.record = record
        self.report = PrintReport()
        self._closed = False
        self._clock, self._asleep = clock, asleep

    def status(self) -> Status | None:
        """What the device says of itself now; None if it says nothing.

        Raises a :class:`devices.errors.PrintError` if it went away.
        """
        self._check_open()
        return self._sender(lambda status: None, lambda: False).ask()

    def print(
        self,
        *pictures: Any,
        copies: int = 1,
        density: int | None = None,
        cut: bool | None = None,
        progress: Callable[[float], None] | None = None,
        cancel: Callable[[], bool] | None = None,
        notify: Callable[[Status], None] | None = None,
        **options: Any,
    ) -> PrintReport:
        """Print *pictures*, a page each, and say how far it came.

        pictures : frames or bands of level indices for this device, as they are; or whatever
        :func:`halftone.convert` takes (a file, an array, linear light), halftoned for this device
        with *options* as there; or a function that gives bands whenever it is called.
        density : how dark, in the device's own numbers; None leaves it as it is. cut : whether the
        paper is cut after each page; None does what the profile says.
        progress : called with the share done. cancel : asked now and then whether to break off: the
        open command is completed, and the report says so (a KeyboardInterrupt in the middle of a
        write would not know what was taken: catch the signal, and cancel). notify : called when the
        device says something new (out of paper, ready again).

        Raises :class:`halftone.errors.UsageError` for what the device cannot do, before it is sent;
        :class:`devices.errors.PrintError`, whose ``report`` says how far it came.
        """
        self._check_open()
        self._check(copies, density, cut)
        _check_pictures(pictures, options)
        self.report = report = PrintReport(self.uri, self.profile.name, self.language.name)
        sender = self._sender(notify or (lambda status: None), cancel or (lambda: False))
        start = self._clock()
        job = _Job(
            self, report, pictures, copies, density, self.profile.cut if cut is None else cut, options
        )
        try:
            self._run(sender, job, progress or (lambda share: None))
        except PrintError as error:
            error.report = report
            raise
        finally:
            report.seconds = round(self._clock() - start, 6)
            report.bytes_accepted = sender.taken
            report.reasons, report.waited = frozenset(sender.seen), round(sender.waited, 3)
        return report

    def close(self) -> None:
        """Give the device back. A second call does nothing."""
        self._closed = True
        self.transport.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if error is not None:
            self.transport.spoil()
        self.close()

    def _check_open(self) -> None:
        if self._closed:
            raise UsageError(f"the device '{self.uri}' is closed; open it again")

    def _sender(self, notify: Callable[[Status], None], cancelled: Callable[[], bool]) -> Sender:
        return Sender(
            self.transport, self.language, self.patience, notify, cancelled, self._clock, self._asleep
        )

    def _check(self, copies: int, density: int | None, cut: bool | None) -> None:
        if isinstance(copies, bool) or not isinstance(copies, int) or not 1 <= copies <= 9999:
            raise UsageError(f"copies = {copies!r}; allowed: 1 … 9999")
        if cut and not self.language.cuts:
            raise UsageError(f"cut: '{self.language.name}' has no command for it; leave it out")
        if density is not None:
            if isinstance(density, bool) or not isinstance(density, int):
                raise UsageError(f"density = {density!r}; allowed: an integer")
            allowed = self.profile.density
            if allowed is None:
                raise UsageError(f"density = {density}: '{self.profile.name}' has no density to set")
            if not allowed[0] <= density <= allowed[1]:
                raise UsageError(
                    f"density = {density}; '{self.profile.name}' allows {allowed[0]} … {allowed[1]}"
                )

    def _run(self, sender: Sender, job: _Job, progress: Callable[[float], None]) -> None:
        """Piece after piece. What ends it early is met by completing what the device has begun."""
        pages = job.pages()
        pieces = self.language.encode(pages)
        begun: tuple[Piece, int] | None = None  # the last piece of which it has any byte, and how many
        try:
            piece = next(pieces, None)  # what the language refuses is refused before a byte is sent
            sender.wait_until_ready(sender.ask())
            while piece is not None:
                before = job.report.rows_accepted
                try:
                    sender.give(piece.data)
                finally:
                    if sender.sent:
                        begun = piece, sender.sent
                    job.accepted(before + piece.accepted(sender.sent))
                    if self.record is not None:
                        self.record(piece.data[: sender.sent])
                progress(job.share())
                piece = next(pieces, None)
            sender.flush()
            job.report.completed = True
        except BaseException as error:
            self.transport.spoil()
            if sender.broken or isinstance(error, PrintError):
                raise
            job.report.completed = begun is None or self._complete(sender, begun[0].abort(begun[1]))
            if not isinstance(error, Cancelled):
                raise
            job.report.cancelled = True
        finally:
            pages.close()

    def _complete(self, sender: Sender, rest: bytes) -> bool:
        """Give the device what completes a broken-off job; whether it took all of it."""
        before = sender.taken
        try:
            return sender.finish(rest)
        except HalftoneError:
            return False
        finally:
            if self.record is not None:
                self.record(rest[: sender.taken - before])


def _check_pictures(pictures: tuple[Any, ...], options: dict[str, Any]) -> None:
    """Refuse what would fail when half of it is printed."""
    if not pictures:
        raise UsageError("nothing to print; give one or more pictures")
    bands = [id(picture) for picture in pictures if isinstance(picture, Bands)]
    if len(set(bands)) < len(bands):
        raise UsageError("bands can be read once, and the same were given twice; print a frame")
    if options:
        from halftone.recipe import Recipe

        allowed = {f.name for f in fields(Recipe) if f.init} - {"profile"}
        for name in options:
            if name not in allowed:
                raise UsageError(near(name, allowed, "option"))


@dataclass
class _Job:
    """The pages of one call of print, made when the language asks for them."""

    device: Device
    report: PrintReport
    pictures: tuple[Any, ...]
    copies: int
    density: int | None
    cut: bool
    options: dict[str, Any]
    ends: list[int] = field(default_factory=list)

    def accepted(self, rows: int) -> None:
        """The device has all bytes of so many rows."""
        self.report.rows_accepted = rows
        self.report.pages_accepted = sum(end <= rows for end in self.ends)

    def pages(self) -> Generator[Page, None, None]:
        device, native = self.device, self.device.language.native_copies
        many = 1 if native else self.copies
        for picture in self.pictures:
            if many > 1 and isinstance(picture, Bands):
                raise UsageError(
                    f"bands can be read once and '{device.language.name}' has no command for copies; "
                    "print a frame, or a file"
                )
            for _ in range(many):
                bands = self._bands(picture)
                self._fits(bands)
                self.report.pages += 1
                self.report.rows += bands.shape[0]
                self.ends.append(self.report.rows)
                copies = self.copies if native else 1
                try:
                    yield page_of(
                        device.language, bands, copies=copies, density=self.density, cut=self.cut
                    )
                finally:  # also when printing failed: the file of a picture is not held open
                    if isinstance(bands.indices, Generator):
                        bands.indices.close()

    def share(self) -> float:
        """How much of the job is done, taking the pages to come as long as those so far."""
        pages = len(self.pictures) * (1 if self.device.language.native_copies else self.copies)
        here = self.report.rows_accepted / max(1, self.report.rows)
        return min(1.0, here * self.report.pages / pages)

    def _bands(self, picture: Any) -> Bands:
        if isinstance(picture, Frame | Bands):
            if self.options:
                raise UsageError(f"a frame is halftoned already: {', '.join(self.options)} cannot apply")
            return picture.bands() if isinstance(picture, Frame) else picture
        if callable(picture):
            return self._bands(picture())
        from halftone.pipeline import convert_bands

        bands = convert_bands(picture, profile=self.device.profile, **self.options)
        self.report.pictures.append(bands.report)
        return bands

    def _fits(self, bands: Bands) -> None:
        """Refuse what the device would crop."""
        profile, (height, width) = self.device.profile, bands.shape
        for name, dots, most in (("wide", width, profile.width), ("high", height, profile.height)):
            if most is not None and dots > most:
                raise UsageError(
                    f"the picture is {dots} dots {name} and '{profile.name}' has {most}: nothing is "
                    "cropped. Print the picture itself, and it is scaled to fit"
                )
        if len(bands.levels) != len(profile.levels):
            raise UsageError(
                f"the picture has {len(bands.levels)} levels and '{profile.name}' {len(profile.levels)}"
            )
