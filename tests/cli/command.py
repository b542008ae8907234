"""Runs the installed command ``halftone`` as a user would."""

from __future__ import annotations

import os
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

__all__ = ["SCRIPT", "Result", "environment", "names_in", "run", "script"]

SCRIPT = Path(sys.executable).with_name("halftone")
TIMEOUT = 60


@dataclass(frozen=True)
class Result:
    """Exit code, stdout as bytes, stderr as text."""

    code: int
    out: bytes
    err: str

    @property
    def text(self) -> str:
        return self.out.decode()

    def complaint(self, code: int) -> str:
        """The one line on stderr of a run that ended with *code* on purpose."""
        assert self.code == code, f"exit code {self.code}, not {code}: {self.err}"
        assert "Traceback" not in self.err
        assert "internal error" not in self.err
        assert self.err.endswith("\n")
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert lines[0].startswith("halftone"), lines[0]
        return lines[0]


def script() -> str:
    """The script beside the Python that runs the tests."""
    assert SCRIPT.is_file(), f"{SCRIPT} is missing: install the package into this environment"
    return str(SCRIPT)


def environment(changes: dict[str, str] | None = None) -> dict[str, str]:
    """This environment with *changes*, without what the person running the tests has set."""
    kept = {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "HALFTONE_TRACEBACK")}
    return kept | {"XDG_CONFIG_HOME": os.devnull} | (changes or {})


def run(
    *args: str | os.PathLike[str],
    input: bytes | None = None,
    env: dict[str, str] | None = None,
    timeout: float = TIMEOUT,
    **more: Any,
) -> Result:
    """``halftone *args*`` with *input* on stdin; *more* goes to subprocess.Popen."""
    streams: dict[str, Any] = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | more
    if input is None:
        streams.setdefault("stdin", subprocess.DEVNULL)
    done = subprocess.run(
        [script(), *map(os.fspath, args)],
        input=input,
        env=environment(env),
        timeout=timeout,
        check=False,
        **streams,
    )
    return Result(done.returncode, done.stdout or b"", (done.stderr or b"").decode())


def names_in(folder: Path) -> list[str]:
    """Everything in *folder*, hidden files too, by name."""
    return sorted(path.name for path in folder.iterdir())
