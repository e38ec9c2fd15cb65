#!/usr/bin/env bash
# Runs the tests of the SIMD kernels, on every instruction set there is, under tools that see wrong memory accesses:
# AddressSanitizer (needs nightly Rust), and valgrind, which knows AVX2 but not AVX-512.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

kernels=(simd:: bvh::gather bvh::sphere ppm::gather ppm::wavefront light::lane_emission)

die() {
    echo "sanitize: $*" >&2
    exit 1
}

cargo +nightly --version >/dev/null 2>&1 || die "a nightly toolchain is needed: rustup toolchain install nightly"
command -v valgrind >/dev/null || die "valgrind is needed: apt-get install valgrind"

echo "== AddressSanitizer"
RUSTFLAGS="-Zsanitizer=address" CARGO_TARGET_DIR="${CARGO_TARGET_DIR:-target}/sanitize" \
    cargo +nightly test --locked --lib --target x86_64-unknown-linux-gnu -- "${kernels[@]}"

echo "== valgrind"
tests=$(cargo test --locked --lib --no-run --message-format=json 2>/dev/null |
    sed -n 's/.*"target":{"kind":\["lib"\].*"executable":"\([^"]*\)".*/\1/p')
[ -n "$tests" ] || die "the program of the tests was not built"
valgrind --quiet --error-exitcode=1 "$tests" --test-threads=1 "${kernels[@]}"
