#!/usr/bin/env bash
# Installs the programs and libraries that tests/peers and tests/bench compare with. A failure is named
# and is not fatal: the tests of that program are then skipped, the benchmark leaves it out, and both
# say so. Libraries bear the names of Debian 12. PYTHON=… chooses whose pip is used.
set -u
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
failed=()
export DEBIAN_FRONTEND=noninteractive
$sudo apt-get update -q >/dev/null 2>&1 || failed+=("apt-get update")
programs=(netpbm libtiff-tools pngcheck imagemagick
    cups cups-client cups-filters ghostscript lprint dbus umockdev # encoders and decoders of printer languages
    qemu-system-x86 busybox-static cpio kmod)                      # a machine with a USB printer gadget
libraries=(libzimg2 liblept5 libswscale6 libcups2 libcupsimage2 libusb-1.0-0)
for package in "${programs[@]}" "${libraries[@]}"; do
    $sudo apt-get install -qy --no-install-recommends "$package" >/dev/null 2>&1 || failed+=("$package")
done
python=${PYTHON:-python3}
[ -n "${PYTHON:-}" ] || [ ! -x .venv/bin/python ] || python=.venv/bin/python
for package in ipp epaper-dithering vtk embreex trimesh python-escpos brother_ql zplgrf; do
    "$python" -m pip install -q "$package" >/dev/null 2>&1 || failed+=("$package (pip of $python)")
done
# What no package manager of the system installs lies in .peers: tests/peers/places.py looks there.
mkdir -p .peers/npm .peers/kernel
command -v npm >/dev/null || $sudo apt-get install -qy --no-install-recommends nodejs npm >/dev/null 2>&1
for package in zpl-renderer-js zpl-image receiptline receiptio @point-of-sale/receipt-printer-encoder; do
    npm install --silent --prefix .peers/npm "$package" >/dev/null 2>&1 || failed+=("$package (npm)")
done
cargo=$(command -v cargo || true)
if [ -z "$cargo" ]; then # Debian's own cargo is too old
    $sudo apt-get install -qy --no-install-recommends cargo-web >/dev/null 2>&1
    cargo=$(command -v cargo cargo-web | head -n 1)
fi
[ -x .peers/cargo/bin/labelize ] || [ -n "$cargo" ] &&
    "$cargo" install -q labelize --version 1.10.0 --features cli --root .peers/cargo >/dev/null 2>&1 ||
    failed+=("labelize (cargo)")
if ! ls .peers/kernel/linux-image-*.deb >/dev/null 2>&1; then
    kernel=$(apt-cache depends linux-image-amd64 2>/dev/null | awk '/Depends: linux-image-/ { print $2; exit }')
    (cd .peers/kernel && apt-get download -q "${kernel:-linux-image-amd64}" >/dev/null 2>&1) ||
        failed+=("a Debian kernel for the virtual machine")
fi
if [ ${#failed[@]} -eq 0 ]; then
    echo "peers: all installed"
else
    printf 'peers: could not install %s\n' "${failed[@]}"
fi
exit 0
