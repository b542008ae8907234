"""The arrows of the house: who may import what, walked over the syntax trees; and its sizes."""

from __future__ import annotations

import ast
import statistics
from pathlib import Path

import pytest

ROOT = Path(__file__).parent.parent

CELLAR = {"errors", "_arrays", "_jit", "_lanes", "_lanes_ir", "_objects", "_parallel"}
LOW = {"vision", "packing", "tone"}
# A frame saves and shows itself, so it needs images; images know a Frame as a type only.
ARROWS = {
    **dict.fromkeys(CELLAR | LOW | {"screens", "scene"}, CELLAR),
    "dithering": CELLAR | {"screens", "tone", "vision"},
    "metrics": CELLAR | {"vision", "tone", "screens", "dithering"},
    "frame": CELLAR | {"packing", "tone", "images"},
    "images": CELLAR | {"packing", "tone"},
    "stages": CELLAR | LOW | {"images", "dithering", "frame"},
    "flatfield": CELLAR | {"tone", "screens", "dithering", "stages"},
    "recipe": CELLAR | LOW | {"images", "dithering", "frame", "stages", "flatfield"},
    "pipeline": CELLAR | {"recipe", "stages"} | LOW | {"images", "screens", "dithering", "frame"},
    "devices": CELLAR | LOW | {"images", "recipe", "pipeline", "frame"},
}
# Third-party packages: only inside functions, only in these files.
LAZY = {
    "numba": {"halftone/_jit.py", "halftone/_lanes_ir.py"},
    "llvmlite": {"halftone/_objects.py", "halftone/_lanes_ir.py"},
    "OpenImageIO": {"halftone/images/read.py"},
    "PIL": {"halftone/images/resize.py", "halftone/cli/demo.py", "halftone/screens/mask.py"},
    "scipy": set(),
    "skimage": set(),
    "colour": set(),
    "matplotlib": set(),
    "usb": {"devices/transports/usb.py", "devices/transports/usb_find.py"},
    "serial": {"devices/transports/serial.py"},
}

FILES = sorted([*ROOT.glob("halftone/**/*.py"), *ROOT.glob("devices/**/*.py")])


def room_of(path: Path) -> str:
    parts = path.relative_to(ROOT).with_suffix("").parts
    if parts[0] == "devices":
        return "devices"
    return parts[1] if len(parts) > 1 else "halftone"


def imports(path: Path) -> list[tuple[str, bool]]:
    """(module, whether at module level) of every import, also of import_module("…")."""
    tree = ast.parse(path.read_text())
    inside = {
        id(node)
        for outer in ast.walk(tree)
        if isinstance(outer, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(outer)
    }
    typing_only = {
        id(node)
        for outer in ast.walk(tree)
        if isinstance(outer, ast.If) and "TYPE_CHECKING" in ast.dump(outer.test)
        for node in ast.walk(outer)
    }
    found = []
    for node in ast.walk(tree):
        top = id(node) not in inside
        if id(node) in typing_only:
            continue
        if isinstance(node, ast.Import):
            found += [(alias.name, top) for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found += [(f"{node.module}.{alias.name}", top) for alias in node.names]
    return found


def target(module: str) -> str | None:
    """The room of an imported module of ours, else None."""
    parts = module.split(".")
    if parts[0] == "devices":
        return "devices"
    if parts[0] != "halftone" or len(parts) < 2:
        return None
    return parts[1]


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_arrows(path):
    room = room_of(path)
    if room in ("cli", "__init__", "__main__"):
        return  # the roof may import anything; the front door names everything
    assert room in ARROWS, f"{path}: the room '{room}' has no place in the house"
    for module, _ in imports(path):
        goal = target(module)
        if goal is not None and goal not in ("__version__", room):
            assert goal in ARROWS[room], f"{path} imports {module}"


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(ROOT)))
def test_third_parties_are_imported_inside_functions_of_named_files(path):
    for module, top in imports(path):
        name = module.split(".")[0]
        if name in LAZY:
            assert str(path.relative_to(ROOT)) in LAZY[name], f"{path} imports {module}"
            assert not top, f"{path} imports {module} at module level"


@pytest.mark.parametrize("path", [f for f in FILES if f.match("_*_kernels.py")], ids=lambda p: p.name)
def test_kernels_import_nothing_else(path):
    """numba's and our caches do not see edits in other files; of _lanes, ours does."""
    for module, _ in imports(path):
        allowed = module.startswith(("halftone._jit", "halftone._lanes."))
        assert module.split(".")[0] in ("numpy", "math") or allowed, module


def test_nobody_imports_the_roof():
    for path in FILES:
        if room_of(path) not in ("cli", "__main__"):
            assert not [m for m, _ in imports(path) if m.startswith("halftone.cli")], path


def test_modules_are_small():
    lines = [len(path.read_text().splitlines()) for path in FILES]
    assert max(lines) <= 400, FILES[lines.index(max(lines))]
    assert statistics.median(lines) <= 180


def test_top_level_names():
    allowed = {"pyproject.toml", "README.md", "LICENSE", "CHANGELOG.md", "CONTRIBUTING.md"}
    allowed |= {"halftone", "devices", "tests", "examples"}
    import subprocess

    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False
    ).stdout.split()
    names = {name.split("/")[0] for name in listed}
    assert {n for n in names if not n.startswith(".")} <= allowed
