#!/usr/bin/env bash
# Has other programs read what this one writes, and renders what they render.
#
# Every check is a file scripts/crosscheck/NAME.py, which is called with the program and a folder for its files. It prints what it
# compared and exits with 1 where programs disagree. As root, missing tools are installed with apt-get, Python's into
# tools/crosscheck; what is still missing then is skipped, visibly.
#
# usage: crosscheck.sh PROGRAM [NAME..]
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

readonly VENV=tools/crosscheck
readonly CHECKS=scripts/crosscheck
readonly OUT=out/crosscheck

note() { echo "crosscheck: $*"; }

is_root() { [ "$(id -u)" = 0 ]; }

install_packages() {
    local missing=()
    command -v oiiotool >/dev/null || missing+=(openimageio-tools)
    command -v exrheader >/dev/null || missing+=(openexr)
    python3 -c 'import ensurepip, venv' 2>/dev/null || missing+=(python3-venv)
    [ ${#missing[@]} != 0 ] || return 0
    if is_root && command -v apt-get >/dev/null; then
        note "installing ${missing[*]}"
        export DEBIAN_FRONTEND=noninteractive
        apt-get update -q </dev/null && apt-get install -y -q --no-install-recommends "${missing[@]}" </dev/null ||
            note "cannot install ${missing[*]}"
    else
        note "missing: ${missing[*]}"
    fi
}

# Made anew where other versions are asked for.
ensure_venv() {
    cmp -s "$VENV/requirements.txt" "$CHECKS/requirements.txt" && return
    note "installing Mitsuba and OpenEXR for Python into $VENV"
    rm -rf "$VENV"
    python3 -m venv "$VENV" &&
        "$VENV/bin/python" -m pip --disable-pip-version-check install -q -r "$CHECKS/requirements.txt" </dev/null &&
        cp "$CHECKS/requirements.txt" "$VENV/"
}

main() {
    [ $# -ge 1 ] || { sed -n 's/^# usage: /usage: /p' "$0" >&2; exit 2; }
    local program=$1 name failed=()
    shift
    [ $# -ge 1 ] || set -- $(basename -s .py "$CHECKS"/[!_]*.py)
    install_packages
    local python=$VENV/bin/python
    ensure_venv || { note "cannot install them: the checks do with what python3 has"; python=python3; }
    for name in "$@"; do
        mkdir -p "$OUT/$name"
        "$python" "$CHECKS/$name.py" "$program" "$OUT/$name" || failed+=("$name")
    done
    if [ ${#failed[@]} != 0 ]; then note "failed: ${failed[*]}"; exit 1; fi
}

main "$@"
