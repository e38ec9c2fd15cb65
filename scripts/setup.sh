#!/usr/bin/env bash
# Brings a machine to the point where `cargo build` works: a C compiler, libclang, Rust and Embree 4.
#
# As root, missing packages are installed with apt-get; otherwise one sentence names them. Where the system has no
# Embree 4, a private prefix is unpacked into .embree/: headers from Debian's libembree-dev, the library from the
# wheel that scripts/embree-library.txt pins. The prefix appears whole or not at all, and a second run does nothing.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly ROOT=$PWD
readonly PREFIX=.embree
readonly PARTIAL=.embree.partial
readonly PINS=scripts/embree-library.txt
readonly HEADERS_SUITE=trixie
readonly DEBIAN_KEYS=/usr/share/keyrings/debian-archive-keyring.gpg

die() {
    echo "setup: $*" >&2
    exit 1
}

is_root() { [ "$(id -u)" = 0 ]; }

exists() { compgen -G "$1" >/dev/null; }

# --- What the build needs from the machine ---------------------------------------------------------------------

has_compiler() { command -v cc >/dev/null; }

# bindgen loads libclang at build time, and libclang needs its own stddef.h beside it.
has_libclang() {
    [ -z "${LIBCLANG_PATH:-}" ] || { exists "$LIBCLANG_PATH/libclang*.so*" && return 0; }
    local llvm=/nowhere
    ! command -v llvm-config >/dev/null || llvm=$(llvm-config --libdir)
    exists "/usr/lib/llvm-*/lib/clang/*/include/stddef.h" || exists "/usr/lib*/clang/*/include/stddef.h" ||
        exists "$llvm/clang/*/include/stddef.h" || return 1
    exists "/usr/lib/llvm-*/lib/libclang.so*" || exists "/usr/lib/llvm-*/lib/libclang-[0-9]*.so*" ||
        exists "$llvm/libclang.so*" || exists "$llvm/libclang-[0-9]*.so*" ||
        grep -qE '\blibclang(-[0-9.]+)?\.so' <<<"$(PATH=$PATH:/sbin:/usr/sbin ldconfig -p)"
}

has_pip() { python3 -m pip --version >/dev/null 2>&1; }

apt_install() {
    command -v apt-get >/dev/null || die "missing: $*. Install them with this system's package manager."
    is_root || die "missing packages; install them as root with: apt-get update && apt-get install -y $*"
    echo "setup: installing $*"
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -q </dev/null
    apt-get install -y -q --no-install-recommends "$@" </dev/null
}

install_packages() {
    local missing=()
    has_compiler || missing+=(gcc libc6-dev)
    has_libclang || missing+=(libclang-dev)
    command -v make >/dev/null || missing+=(make)
    if needs_prefix; then
        command -v dpkg-deb >/dev/null || missing+=(dpkg)
        has_pip || missing+=(python3-pip)
        [ -e /etc/ssl/certs/ca-certificates.crt ] || missing+=(ca-certificates)
    fi
    [ ${#missing[@]} = 0 ] || apt_install "${missing[@]}"
}

# --- Rust ------------------------------------------------------------------------------------------------------

apt_offers() { [ -n "$(apt-cache madison "$1" 2>/dev/null)" ]; }

ensure_rust() {
    local wanted have
    wanted=$(sed -n 's/^rust-version *= *"\(.*\)"/\1/p' Cargo.toml)
    if ! command -v cargo >/dev/null && is_root && apt_offers rustup; then
        apt_install rustup
    fi
    command -v cargo >/dev/null || die "cargo is missing: install Rust $wanted or newer with rustup"
    if ! have=$(cargo --version 2>/dev/null); then
        if ! is_root || ! command -v rustup >/dev/null; then
            die "cargo does not run: install a toolchain with rustup default stable"
        fi
        rustup default stable
        have=$(cargo --version)
    fi
    have=$(cut -d' ' -f2 <<<"$have")
    [ "$(printf '%s\n' "$wanted" "$have" | sort -V | head -n1)" = "$wanted" ] ||
        die "cargo $have is older than $wanted: install a newer Rust with rustup update stable"
}

# --- Embree 4 --------------------------------------------------------------------------------------------------

# As build.rs wants it: 4.3 or a newer 4.
system_has_embree() {
    local root
    for root in /usr/local /usr; do
        if grep -qsE '^#define RTC_VERSION 4(0[3-9]|[1-9][0-9])[0-9]{2}$' "$root/include/embree4/rtcore_config.h" &&
            { exists "$root/lib/libembree4.so" || exists "$root/lib64/libembree4.so" ||
                exists "$root/lib/*-linux-gnu/libembree4.so"; }; then
            return 0
        fi
    done
    return 1
}

prefix_is_whole() {
    [ -e "$PREFIX/include/embree4/rtcore.h" ] && [ -e "$PREFIX/lib/libembree4.so" ] && cmp -s "$PREFIX/pins" "$PINS"
}

# A prefix from older pins is replaced even beside a system's Embree, since the build would take it first.
needs_prefix() {
    [ -z "${EMBREE_DIR:-}" ] && ! prefix_is_whole && { [ -e "$PREFIX" ] || ! system_has_embree; }
}

# apt with its own lists and cache below $PARTIAL and without the machine's hooks: its mirrors and proxies are known,
# its state stays untouched.
private_apt() {
    local home=$ROOT/$PARTIAL/apt
    mkdir -p "$home/lists/partial" "$home/cache/archives/partial"
    cat >"$home/apt.conf" <<CONF
#clear APT::Update::Post-Invoke;
#clear APT::Update::Post-Invoke-Success;
Acquire::Retries "3";
Dir::State::lists "$home/lists";
Dir::Cache "$home/cache";
CONF
    ! is_root || echo 'APT::Sandbox::User "root";' >>"$home/apt.conf"
    apt-get -q -c "$home/apt.conf" "$@" </dev/null
}

# Archives that may be Debian's own, likeliest first: their signature decides.
debian_mirrors() {
    private_apt update --print-uris | sed -n "s|^'\(.*\)/dists/\([^/]*\)/InRelease'.*|\2 \1|p" |
        awk '$1 !~ /security|updates|backports/ && !seen[$2]++ { print ($2 ~ /\/debian\/?$/ ? 0 : 1), $2 }' |
        sort -s -n -k1,1 | cut -d' ' -f2
}

fetch_headers() {
    local mirror sources=$ROOT/$PARTIAL/apt/sources.list
    local only=(-o "Dir::Etc::sourcelist=$sources" -o Dir::Etc::sourceparts=-)
    for mirror in $(debian_mirrors); do
        echo "deb [target=Packages lang=none signed-by=$DEBIAN_KEYS] $mirror $HEADERS_SUITE main" >"$sources"
        if private_apt "${only[@]}" update && (cd "$PARTIAL/apt" && private_apt "${only[@]}" download libembree-dev); then
            dpkg-deb -x "$PARTIAL"/apt/libembree-dev_4*.deb "$PARTIAL/headers"
            return
        fi
    done
    die "no archive of this machine offers the Embree 4 headers: install libembree-dev 4.3 or newer, or set EMBREE_DIR to a" \
        "prefix that holds include/embree4 and lib"
}

fetch_library() {
    # Whatever python3 runs here, the wheel is the pinned one: only its two libraries are used.
    python3 -m pip --disable-pip-version-check download --quiet --no-cache-dir --no-deps --only-binary=:all: \
        --python-version 3.11 --implementation cp --abi cp311 --platform manylinux_2_28_x86_64 \
        --require-hashes -r "$PINS" -d "$PARTIAL/wheel" </dev/null ||
        die "cannot download the Embree library: see pip's words above"
    python3 -m zipfile -e "$PARTIAL"/wheel/embreex-*.whl "$PARTIAL/wheel"
}

assemble_prefix() {
    local whole=$PARTIAL/whole
    mkdir -p "$whole/include" "$whole/lib" "$whole/share/doc"
    cp -r "$PARTIAL/headers/usr/include/embree4" "$whole/include/"
    cp "$PARTIAL/headers/usr/share/doc/libembree-dev/copyright" "$whole/share/doc/embree-copyright"
    cp "$PARTIAL"/wheel/embreex.libs/lib{embree4,tbb}-* "$whole/lib/"
    (cd "$whole/lib" && ln -s libembree4-*.so.4 libembree4.so)
    cp "$PINS" "$whole/pins"
    rm -rf "$PREFIX"
    mv "$whole" "$PREFIX"
}

make_prefix() {
    [ "$(uname -m)" = x86_64 ] || die "there is no prebuilt Embree 4 for $(uname -m): install it and set EMBREE_DIR"
    command -v apt-get >/dev/null || die "Embree 4 is missing: install it and set EMBREE_DIR to its prefix"
    echo "setup: unpacking Embree 4 into $PREFIX"
    rm -rf "$PARTIAL"
    trap 'rm -rf "$PARTIAL"' EXIT
    mkdir "$PARTIAL"
    echo '*' >"$PARTIAL/.gitignore"
    fetch_headers
    fetch_library
    assemble_prefix
}

main() {
    # Two set-ups at once would unpack into each other: the second waits, then finds the work done.
    exec 9<scripts/setup.sh
    flock 9
    install_packages
    ensure_rust
    if needs_prefix; then make_prefix; else rm -rf "$PARTIAL"; fi
}

main
