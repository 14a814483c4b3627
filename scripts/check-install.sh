#!/usr/bin/env bash
# Installs a build into a scratch folder, then builds and runs a program against it, as a user of Catan would.
#   scripts/check-install.sh BUILD
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/check-install.sh BUILD}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/prefix/bin/catan" --version
cmake -S tests/install -B "$scratch/user" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" --log-level=WARNING >/dev/null
cmake --build "$scratch/user" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/user/user" tests/install/app.yaml
