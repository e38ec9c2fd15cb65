#!/usr/bin/env bash
# Fuzzes the loaders: scripts/fuzz.sh SECONDS [TARGET...], all targets without one. Stops at the first finding.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

die() {
    echo "fuzz: $*" >&2
    exit 1
}

[ $# -ge 1 ] || die "usage: scripts/fuzz.sh SECONDS [TARGET...]"
seconds=$1
shift
cargo +nightly --version >/dev/null 2>&1 || die "a nightly toolchain is needed: rustup toolchain install nightly"
cargo +nightly fuzz --version >/dev/null 2>&1 || die "cargo-fuzz is needed: cargo install cargo-fuzz"

targets=("$@")
[ ${#targets[@]} -gt 0 ] || mapfile -t targets < <(cargo +nightly fuzz list)
# Everything but the fence is safe Rust, so a sanitizer of memory would only slow it down.
build=(-O -s none)
for target in "${targets[@]}"; do
    mkdir -p "fuzz/corpus/$target"
    echo "== $target"
    cargo +nightly fuzz run "${build[@]}" "$target" "fuzz/corpus/$target" "fuzz/seeds/$target" -- \
        -dict="fuzz/dictionaries/$target.txt" -max_total_time="$seconds" -max_len=65536 \
        -rss_limit_mb=1024 -malloc_limit_mb=1024 -timeout=1 -print_final_stats=1 -verbosity=0
done
