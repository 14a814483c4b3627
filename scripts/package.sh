#!/usr/bin/env bash
# Makes the Debian package from a build in which the target package_contents is built: out/package/catan_VERSION_ARCH.deb.
#   scripts/package.sh BUILD
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/package.sh BUILD}
packaging/manual.sh "$build/tools/catan/catan" "$build/manual"
gzip -9nc CHANGELOG.md >"$build/manual/changelog.gz"
rm -rf out/package
mkdir -p out/package
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cpack --config "$build/CPackConfig.cmake" -B "$PWD/out/package" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf out/package/_CPack_Packages
ls out/package/*.deb
