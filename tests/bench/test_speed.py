"""The benchmark's quick form, all of it, as ``pytest -m bench -s``; any wrong result fails."""

from __future__ import annotations

import pytest

from tests.bench.jobs import JOBS
from tests.bench.speed import main

pytestmark = pytest.mark.bench


def test_the_benchmark_prints_every_job(capsys, tmp_path):
    assert main(["--quick", "--largest", "--md", str(tmp_path / "speed.md")]) == 0
    text = capsys.readouterr().out
    with capsys.disabled():
        print(f"\n{text}")
    for job in JOBS:
        assert f"| {job.title} |" in text
    for section in ("Ours beside ours", "Void-and-cluster", "Whole processes", "Largest picture"):
        assert section in text
    assert (tmp_path / "speed.md").read_text() == text
