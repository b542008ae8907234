"""A virtual machine with Debian's kernel, to have what this one may lack: real USB printers and usblp.

Its file system is this machine's, read-only, under an overlay that is thrown away, so a script in it
runs with the same Python, libraries and tests. Its USB is dummy_hcd: a host controller and a device
controller in one, wired to each other; usb_f_printer is a printer at its device end.
"""

from __future__ import annotations

import hashlib
import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from tests.peers import places

__all__ = ["run"]

ROOT = Path(__file__).parent.parent.parent
SHARED = ["virtio_pci", "9pnet_virtio", "9p", "overlay"]
MODULES = [*SHARED, "configfs", "dummy_hcd", "libcomposite", "usb_f_printer", "usb_f_fs", "usblp", "vfb"]
INIT = """#!/bin/busybox sh
bb=/bin/busybox
$bb mount -t proc proc /proc
$bb mount -t sysfs sys /sys
$bb mount -t devtmpfs dev /dev
for module in $($bb cat /modules/order); do
    options=; [ $module = vfb.ko ] && options=vfb_enable=1
    $bb insmod /modules/$module $options || echo "insmod $module failed" > /dev/ttyS1
done
$bb mount -t configfs config /sys/kernel/config
$bb mount -t 9p -o trans=virtio,version=9p2000.L,msize=512000,cache=loose,ro host /lower
$bb mount -t tmpfs over /over
$bb mkdir /over/upper /over/work
$bb mount -t overlay -o lowerdir=/lower,upperdir=/over/upper,workdir=/over/work over /new
for folder in proc sys dev; do $bb mount --move /$folder /new/$folder; done
$bb ifconfig lo 127.0.0.1
eval "$($bb sed -n 's/.*halftone="\\(.*\\)".*/\\1/p' /new/proc/cmdline)"
$bb chroot /new $PROGRAM $SCRIPT < /new/dev/null > /new/dev/ttyS1 2>&1
echo "exit $?" > /new/dev/ttyS1
$bb sync
$bb reboot -f
"""
READY = b"exit "


def run(script: str, timeout: float = 120.0) -> str:
    """What *script*, a program in Python, writes in the machine, where it is root and can import the
    tests. Raises AssertionError with all it wrote if it fails. Skips the test if there is no kernel."""
    qemu = places.program("qemu-system-x86_64")
    kernel, initramfs = _boot_files()
    with tempfile.TemporaryDirectory(prefix="halftone-vm-") as folder:
        path = Path(folder, "script.py")
        path.write_text(f"import sys\nsys.path.insert(0, {str(ROOT)!r})\n{script}")
        log = Path(folder, "kernel.log")
        shared = "local,path=/,mount_tag=host,security_model=none,readonly=on,multidevs=remap"
        command = [qemu, "-accel", "tcg,thread=multi", "-cpu", "max", "-smp", "2", "-m", "1024"]
        command += ["-nodefaults", "-display", "none", "-no-reboot", "-virtfs", shared]
        command += ["-kernel", str(kernel), "-initrd", str(initramfs)]
        command += ["-serial", f"file:{log}", "-serial", "stdio"]
        told = f'halftone="PROGRAM={shlex.quote(sys.executable)} SCRIPT={shlex.quote(str(path))}"'
        command += ["-append", f"console=ttyS0 loglevel=4 panic=-1 mitigations=off {told}"]
        try:
            done = subprocess.run(
                command, stdin=subprocess.DEVNULL, capture_output=True, timeout=timeout, check=False
            )
            output, errors = done.stdout, done.stderr
        except subprocess.TimeoutExpired as error:
            output, errors = error.stdout or b"", f"not done in {timeout:g} s".encode()
        kernel_said = log.read_bytes()[-3000:] if log.exists() else b""
    body, mark, code = output.replace(b"\r\n", b"\n").rpartition(READY)
    if not mark or code.strip() != b"0":
        parts = (b"in the virtual machine:", output, errors, b"its kernel:", kernel_said)
        raise AssertionError(b"\n".join(parts).decode(errors="replace"))
    return body.decode(errors="replace")


def _boot_files() -> tuple[Path, Path]:
    """The kernel, and its first file system: busybox, the modules and INIT. They are made once."""
    busybox = places.program("busybox")
    packages = sorted((places.FOLDER / "kernel").glob("linux-image-*.deb"))
    if not packages:
        import pytest

        pytest.skip("there is no kernel in .peers/kernel (tests/peers/install.sh fetches it)")
    key = hashlib.sha256(f"{packages[-1].name} {MODULES} {INIT}".encode()).hexdigest()[:16]
    made = places.FOLDER / f"vm-{key}"
    if not made.is_dir():
        with tempfile.TemporaryDirectory(prefix="halftone-vm-") as folder:
            _make(Path(folder), packages[-1], busybox)
            try:
                shutil.copytree(Path(folder, "made"), f"{made}.{os.getpid()}")
                Path(f"{made}.{os.getpid()}").rename(made)
            except OSError:
                if not made.is_dir():  # else another test run was faster
                    raise
    return made / "vmlinuz", made / "initramfs"


def _make(folder: Path, package: Path, busybox: str) -> None:
    cpio, depmod = places.program("cpio"), places.program("depmod")
    subprocess.run(["dpkg", "-x", str(package), str(folder / "k")], check=True)
    (release,) = [each.name for each in (folder / "k/lib/modules").iterdir()]
    subprocess.run([depmod, "-b", str(folder / "k"), release], check=True)
    root = folder / "root"
    for name in ("bin", "dev", "lower", "modules", "new", "over", "proc", "sys"):
        (root / name).mkdir(parents=True)
    shutil.copy(busybox, root / "bin/busybox")
    tree = folder / "k/lib/modules" / release
    order = _in_order(tree)
    for path in order:
        shutil.copy(tree / path, root / "modules")
    (root / "modules/order").write_text("\n".join(Path(path).name for path in order))
    (root / "init").write_text(INIT)
    (root / "init").chmod(0o755)
    made = folder / "made"
    made.mkdir()
    shutil.copy(folder / f"k/boot/vmlinuz-{release}", made / "vmlinuz")
    names = "\n".join(str(path.relative_to(root)) for path in sorted(root.rglob("*"))).encode()
    with (made / "initramfs").open("wb") as archive:
        pack = [cpio, "--quiet", "-o", "-H", "newc"]
        subprocess.run(pack, input=names, cwd=root, stdout=archive, check=True)


def _in_order(tree: Path) -> list[str]:
    """The files of MODULES and of all they need, those that are needed first."""
    needs = {}
    for line in (tree / "modules.dep").read_text().splitlines():
        path, _, rest = line.partition(":")
        needs[path] = rest.split()  # depmod lists what is needed first last
    by_name = {Path(path).name.partition(".")[0]: path for path in needs}
    order: list[str] = []
    for name in MODULES:
        if name in by_name:  # else it is built in
            path = by_name[name]
            order += [each for each in [*reversed(needs[path]), path] if each not in order]
    return order
