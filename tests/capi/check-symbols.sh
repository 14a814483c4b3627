#!/bin/sh
# The functions that a library shows are those that its header declares: check-symbols.sh LIBRARY HEADER
command -v nm >/dev/null || { echo "skipped: there is no nm"; exit 77; }
shown=$(nm -D --defined-only "$1" | awk '{ print $3 }' | sort)
declared=$(grep -oE '\bcatan_[a-z_]+\(' "$2" | tr -d '(' | sort -u)
declared=$(printf '%s\n' "$declared" | while read -r name; do grep -qE "^[a-z].*[ *]$name\(" "$2" && echo "$name"; done)
[ "$shown" = "$declared" ] && exit 0
printf 'shown:\n%s\n\ndeclared:\n%s\n' "$shown" "$declared"
exit 1
