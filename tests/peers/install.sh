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
programs=(netpbm libtiff-tools pngcheck imagemagick)
libraries=(libzimg2 liblept5 libswscale6)
for package in "${programs[@]}" "${libraries[@]}"; do
    $sudo apt-get install -qy --no-install-recommends "$package" >/dev/null 2>&1 || failed+=("$package")
done
python=${PYTHON:-python3}
[ -n "${PYTHON:-}" ] || [ ! -x .venv/bin/python ] || python=.venv/bin/python
for package in ipp epaper-dithering vtk embreex trimesh; do
    "$python" -m pip install -q "$package" >/dev/null 2>&1 || failed+=("$package (pip of $python)")
done
if [ ${#failed[@]} -eq 0 ]; then
    echo "peers: all installed"
else
    printf 'peers: could not install %s\n' "${failed[@]}"
fi
exit 0
