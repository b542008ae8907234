"""``halftone devices``: what is there, what it is, how it is, and what is in the way."""

from __future__ import annotations

import argparse
from typing import Any

__all__ = ["arguments", "run"]

_WHAT = {
    "list": "the printers that are there, with the URI that opens each",
    "info": "a device profile, and its language with all options",
    "languages": "the languages, with their options",
    "status": "what the device at a URI says of itself",
    "doctor": "what keeps printers, or the one at a URI, from being used, and the remedy",
}


def arguments(parser: argparse.ArgumentParser) -> None:
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.epilog = "\n".join(f"  {name:10} {text}" for name, text in _WHAT.items())
    parser.add_argument("what", choices=_WHAT, metavar="|".join(_WHAT))
    parser.add_argument("paths", nargs="*", metavar="NAME|URI")
    parser.add_argument("-d", "--device", metavar="NAME", help="for status: the profile at the URI")
    parser.add_argument(
        "--timeout", type=float, default=5.0, metavar="S", help="for status and doctor (5)"
    )
    parser.add_argument("--json", action="store_true", help="as JSON")


def run(options: argparse.Namespace) -> int:
    """One of list, info, languages, status, doctor."""
    from halftone.cli.console import our_devices
    from halftone.errors import UsageError

    our_devices()
    if len(options.paths) > 1:
        raise UsageError(f"devices {options.what} takes one NAME or URI, not {len(options.paths)}")
    options.target = options.paths[0] if options.paths else None
    if options.what in ("info", "status") and options.target is None:
        raise UsageError(f"devices {options.what} needs a {'NAME' if options.what == 'info' else 'URI'}")
    if options.what in ("list", "languages") and options.target is not None:
        raise UsageError(f"devices {options.what} takes no '{options.target}'")
    if options.device is not None and options.what != "status":
        raise UsageError(f"--device does not apply to devices {options.what}")
    return _COMMANDS[options.what](options)


def _show(options: argparse.Namespace, rows: list[dict[str, Any]], nothing: str) -> int:
    from halftone.cli.listing import show_table

    if options.json:
        import json

        print(json.dumps(rows, indent=1, ensure_ascii=False))
    elif rows:
        show_table(rows)
    else:
        print(nothing)
    return 0


def _list(options: argparse.Namespace) -> int:
    from devices.discovery import found

    rows = [
        {"uri": f.uri, "device": f.title, "languages": ",".join(f.languages), "problem": f.problem}
        for f in found()
    ]
    return _show(options, rows, "no printer was found (halftone devices doctor says what to look at)")


def _info(options: argparse.Namespace) -> int:
    import dataclasses

    from devices.profile import load
    from devices.registry import language_for

    profile = load(options.target)
    fields = {f.name: getattr(profile, f.name) for f in dataclasses.fields(profile)}
    if profile.language is not None:
        made = language_for(profile)
        fields["options"] = {f.name: getattr(made, f.name) for f in dataclasses.fields(made)}  # type: ignore[arg-type]
    if options.json:
        import json

        print(json.dumps(fields, indent=1, ensure_ascii=False, default=str))
        return 0
    for name, value in fields.items():
        if value is None:
            continue
        if isinstance(value, dict):
            value = "  ".join(f"{k}={v}" for k, v in value.items())
        print(f"{name:16} {value}")
    return 0


def _languages(options: argparse.Namespace) -> int:
    import dataclasses

    from devices.languages import language_type, languages

    rows = []
    for name in languages():
        kind = language_type(name)
        given = [f"{f.name}={f.default}" for f in dataclasses.fields(kind) if f.init]  # type: ignore[arg-type]
        rows.append({"language": name, "what": kind.title, "options": " ".join(given)})
    return _show(options, rows, "")


def _status(options: argparse.Namespace) -> int:
    from devices.profile import load
    from devices.registry import open_device
    from devices.sending import Patience
    from devices.transports.base import Uri

    if options.device is not None:
        profile: Any = load(options.device)
    else:
        profile = load("generic-1bit")
        if Uri.parse(options.target).language is None:
            from halftone.errors import UsageError

            raise UsageError("name its language, as escpos+usb://…, or its profile with --device")
    patience = Patience(options.timeout, fault=options.timeout, answer=options.timeout)
    with open_device(options.target, profile, patience=patience, timeout=options.timeout) as device:
        status = device.status()
    reasons = [] if status is None else sorted(status.reasons)
    if options.json:
        import json

        answer = {"answers": status is not None, "reasons": reasons}
        print(json.dumps(answer | {"stopped": bool(status and status.stopped)}, indent=1))
    else:
        print("it says nothing of itself" if status is None else f"{status}")
        for reason in reasons:
            print(f"  {reason}")
    return 5 if status is not None and status.stopped else 0


def _doctor(options: argparse.Namespace) -> int:
    from devices.doctor import examine

    findings = examine(options.target, timeout=options.timeout)
    if options.json:
        import dataclasses
        import json

        print(json.dumps([dataclasses.asdict(f) for f in findings], indent=1, ensure_ascii=False))
    else:
        for finding in findings:
            print(f"{'ok ' if finding.ok else 'BAD'} {finding.what}")
            for line in finding.remedy.splitlines():
                print(f"      {line}")
    return 0 if all(finding.ok for finding in findings) else 4


_COMMANDS = {
    "list": _list,
    "info": _info,
    "languages": _languages,
    "status": _status,
    "doctor": _doctor,
}
