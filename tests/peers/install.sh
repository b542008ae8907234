#!/usr/bin/env bash
# Installs the programs that the tests in this folder compare with. A failure is named and is not fatal:
# the tests of that program are then skipped, and say so.
set -u
sudo=
[ "$(id -u)" = 0 ] || sudo=sudo
failed=()
export DEBIAN_FRONTEND=noninteractive
$sudo apt-get update -q >/dev/null 2>&1 || failed+=("apt-get update")
for package in netpbm libtiff-tools pngcheck imagemagick; do
    $sudo apt-get install -qy --no-install-recommends "$package" >/dev/null 2>&1 || failed+=("$package")
done
if [ ${#failed[@]} -eq 0 ]; then
    echo "peers: all installed"
else
    printf 'peers: could not install %s\n' "${failed[@]}"
fi
exit 0
