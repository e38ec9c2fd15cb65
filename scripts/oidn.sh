#!/usr/bin/env bash
# Unpacks a private copy of Open Image Denoise into tools/oidn, from the wheel that scripts/oidn-library.txt pins: as much of it as
# runs on the processor. Debian 12 has no package of it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly PREFIX=tools/oidn
readonly PINS=scripts/oidn-library.txt

if cmp -s "$PINS" "$PREFIX/pins"; then exit; fi
[ "$(uname -sm)" = "Linux x86_64" ] || {
    echo "oidn: there is no prebuilt library for $(uname -sm): install it and set OIDN_DIR to its prefix" >&2
    exit 1
}
partial=$(mktemp -d)
trap 'rm -rf "$partial"' EXIT
python3 -m pip --disable-pip-version-check download --quiet --no-cache-dir --no-deps --only-binary=:all: \
    --platform manylinux2014_x86_64 --require-hashes -r "$PINS" -d "$partial" </dev/null
python3 -m zipfile -e "$partial"/pyoidn-*.whl "$partial"
rm -rf "$PREFIX"
mkdir -p "$PREFIX/lib"
cp -P "$partial"/pyoidn/oidn/lib/lib{OpenImageDenoise.so,OpenImageDenoise_core,OpenImageDenoise_device_cpu,tbb.so}* "$PREFIX/lib/"
cp "$PINS" "$PREFIX/pins"
