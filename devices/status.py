"""What a device says of itself, in the words of IPP (RFC 8011 §5.4.12, PWG 5100.9)."""

from __future__ import annotations

from dataclasses import dataclass

from halftone.errors import UsageError

__all__ = ["KEYWORDS", "Status"]

KEYWORDS = {
    "media-empty": "no paper",
    "media-low": "paper is running out",
    "media-jam": "paper is jammed",
    "media-needed": "the wrong paper is loaded",
    "cover-open": "the cover is open",
    "door-open": "a door is open",
    "interlock-open": "an interlock is open",
    "marker-supply-empty": "no ribbon, ink or toner",
    "marker-supply-low": "ribbon, ink or toner is running out",
    "marker-failure": "the head or the cutter failed",
    "fuser-over-temp": "the head is too hot",
    "spool-area-full": "its memory is full",
    "offline": "it is offline",
    "paused": "it is paused",
    "moving-to-paused": "it is being paused",
    "timed-out": "it does not answer",
    "other": "it reports a fault it does not name",
}
"""printer-state-reasons keywords, and what they mean to a person."""

PAPER_EMPTY, SELECTED, NO_ERROR = 0x20, 0x10, 0x08
SEVERITIES = ("error", "warning", "report")


@dataclass(frozen=True)
class Status:
    """What holds a device up, or soon will.

    reasons : IPP keywords with a severity, as ``media-empty-error``; empty when all is well. Errors
    stop the device until a person has seen to them, warnings and reports do not.
    """

    reasons: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        for reason in self.reasons:
            keyword, _, severity = reason.rpartition("-")
            if keyword not in KEYWORDS or severity not in SEVERITIES:
                raise UsageError(f"'{reason}' is not an IPP state reason with a severity")

    @classmethod
    def of(cls, *reasons: str) -> Status:
        return cls(frozenset(reasons))

    @classmethod
    def of_port(cls, bits: int) -> Status | None:
        """The byte of GET_PORT_STATUS (USB printer class 1.1 §4.2.2), as usblp gives it too.

        None for the constants of printers that do not fill it in.
        """
        if bits in (0x00, 0xFF):
            return None
        reasons = ["media-empty-error"] * bool(bits & PAPER_EMPTY)
        reasons += ["offline-error"] * (not bits & SELECTED)
        if not bits & NO_ERROR and not reasons:
            reasons.append("other-error")  # else the error has its name already
        return cls.of(*reasons)

    @property
    def stopped(self) -> bool:
        """Whether it cannot go on until a person has seen to it."""
        return any(reason.endswith("-error") for reason in self.reasons)

    def __or__(self, other: Status) -> Status:
        return Status(self.reasons | other.reasons)

    def __str__(self) -> str:
        words = [KEYWORDS[reason.rpartition("-")[0]] for reason in sorted(self.reasons)]
        return ", ".join(words) or "ready"
