"""epaper-dithering (Rust): the one peer on pip with a serpentine scan."""

from __future__ import annotations

import importlib.metadata
from collections.abc import Callable

import numpy as np

from tests.bench.peers.base import Bytes, Peer, Timed


def load() -> Peer:
    import epaper_dithering  # noqa: F401 (found out here whether it is installed)

    return Peer(
        "epaper-dithering",
        importlib.metadata.version("epaper-dithering"),
        "keeps the mean of the codes, not of the light; three channels to a palette picture",
        {
            "fs": _job("FLOYD_STEINBERG", serpentine=False),
            "fs-serpentine": _job("FLOYD_STEINBERG", serpentine=True),
        },
        slow=True,
    )


def _job(mode: str, serpentine: bool) -> Callable[[Bytes], Timed]:
    def timed(codes: Bytes) -> Timed:
        import epaper_dithering
        from PIL import Image

        image = Image.fromarray(codes).convert("RGB")
        scheme, kind = epaper_dithering.ColorScheme.MONO, epaper_dithering.DitherMode[mode]
        return Timed(
            lambda: epaper_dithering.dither_image(image, scheme, mode=kind, serpentine=serpentine),
            lambda made: np.asarray(made.convert("L")) // np.uint8(255),
        )

    return timed
