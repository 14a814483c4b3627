#!/usr/bin/env bash
# Makes the Debian package from a build in which the target package_contents is built: out/package/catan_VERSION_ARCH.deb.
#   scripts/package.sh BUILD
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/package.sh BUILD}
packaging/manual.sh "$build/tools/catan/catan" "$build/manual"
mkdir -p "$build/changelogs"
gzip -9nc CHANGELOG.md >"$build/changelogs/changelog.gz"
version=$("$build/tools/catan/catan" --version | sed 's/^catan //')
gzip -9n >"$build/changelogs/changelog.Debian.gz" <<END
catan ($version-1) unstable; urgency=medium

  * What is new is in changelog.gz.

 -- The authors of Catan <catan@example.org>  $(date -Ru -d "$(git log -1 --format=%cI 2>/dev/null || date -R)")
END
rm -rf out/package
mkdir -p out/package
log=$(mktemp)
trap 'rm -f "$log"' EXIT
cpack --config "$build/CPackConfig.cmake" -B "$PWD/out/package" >"$log" 2>&1 || { cat "$log" >&2; exit 1; }
rm -rf out/package/_CPack_Packages
ls out/package/*.deb
