#!/usr/bin/env bash
# Does what a page with commands tells its reader to: run.sh PAGE PREFIX [FILE...], where Catan is installed in PREFIX, and the
# page takes FILE for there.
#
# Of the page's fenced blocks, in order: one below a line that is a file's name in backquotes and a colon becomes that file; a
# block of `sh` is run, each of its lines printed first. Any command that fails, fails the test; other blocks are only shown.
set -euo pipefail
page=$(readlink -f "$1")
prefix=$(readlink -f "$2")
folder=$(mktemp -d)
trap 'jobs=$(jobs -p); [ -z "$jobs" ] || kill $jobs 2>/dev/null; rm -rf "$folder"' EXIT
cp -- "${@:3}" "$folder" 2>/dev/null || [ $# = 2 ]
cd "$folder"

awk '
  /^```/ && !inside {
    inside = 1
    language = substr($0, 4)
    if (file != "") printf "cat > %s <<'\''END_OF_FILE'\''\n", file
    else if (language != "sh") skip = 1
    next
  }
  /^```/ { if (file != "") print "END_OF_FILE"; inside = skip = 0; file = ""; next }
  inside { if (!skip) print; next }
  /^`[^`]+`:$/ { file = substr($0, 2, length($0) - 3); next }
  { file = "" }
' "$page" > commands.sh
[ "$(grep -c . commands.sh)" -gt 10 ] || { echo "the page has no commands"; exit 1; }

export PATH="$prefix/bin:$PATH" CMAKE_PREFIX_PATH="$prefix" XDG_RUNTIME_DIR="$folder"
unset CATAN_SOCKET
bash -euvo pipefail commands.sh
