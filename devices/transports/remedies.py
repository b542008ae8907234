"""Who holds a device, what forbids it, and what a user does about it, on Linux."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

__all__ = ["holders", "let_go", "permit", "rule"]


def rule(vendor: str, product: str) -> str:
    """The line for udev that lets the user at the machine, and the group lp, open a USB printer.

    vendor, product : ids, four hexadecimal digits.
    """
    return (
        f'SUBSYSTEM=="usb", ATTR{{idVendor}}=="{vendor}", ATTR{{idProduct}}=="{product}", '
        'MODE="0660", GROUP="lp", TAG+="uaccess"'
    )


def permit(vendor: str, product: str) -> str:
    """What gives this user the right to open a USB printer, line by line."""
    return (
        f"write this line to /etc/udev/rules.d/70-halftone-{vendor}-{product}.rules:\n"
        f"{rule(vendor, product)}\n"
        "then run\n"
        "sudo udevadm control --reload && sudo udevadm trigger --subsystem-match=usb\n"
        "and plug it in again; over ssh, join the group too, and log in again:\n"
        "sudo usermod -aG lp $USER"
    )


def let_go(name: str, process: int | None = None) -> str:
    """How to get a device back from the program or kernel driver *name*."""
    if name == "ipp-usb":
        return "print by IPP, which ipp-usb offers for it, or stop it: sudo systemctl stop ipp-usb"
    if name == "usblp":
        return "print to file:/dev/usb/lp0 and the like, or let go of it: sudo modprobe -r usblp"
    if name in ("usb", "cupsd"):
        return "CUPS is printing to it: wait, or: cupsdisable <queue>"
    if process is not None:
        return f"wait until it is done, or end it: kill {process}"
    return "close the program that has it open (cups, ipp-usb, a virtual machine?)"


def holders(node: str, root: Path) -> Iterator[tuple[int, str]]:
    """The other processes that have *node* open, by number and name, as far as this user may see.

    root : another folder to look in, with proc and dev.
    """
    meant = {node, os.path.realpath(root / node.lstrip("/"))}
    for folder in sorted((root / "proc").glob("[0-9]*")):
        if int(folder.name) == os.getpid():
            continue
        try:
            files = {os.readlink(file) for file in (folder / "fd").iterdir()}  # noqa: PTH115
            if meant & files:
                yield int(folder.name), (folder / "comm").read_text("utf-8", "replace").strip()
        except OSError:  # it has ended, or belongs to someone else
            continue
