#!/usr/bin/env bash
# Installs the Debian package that scripts/package.sh made, uses it as its user would, and removes it again.
#   scripts/check-package.sh [PACKAGE]
# As root, dpkg installs it on this machine, unless a package of its name is there already; otherwise, and then, its files are
# unpacked into a scratch folder and used from there.
set -euo pipefail
cd "$(dirname "$0")/.."
package=${1:-$(ls out/package/catan_*.deb)}
scratch=$(mktemp -d)
installed=
finish() {
  [[ -z $installed ]] || dpkg --purge catan >/dev/null
  rm -rf "$scratch"
}
trap finish EXIT
fail() {
  echo "check-package: $*" >&2
  exit 1
}

dpkg-deb --info "$package" | sed -n 's/^ \(Package\|Version\|Depends\|Installed-Size\)/\1/p'
root=$scratch/root
there=$(dpkg-query -W -f='${db:Status-Status}' catan 2>/dev/null || true)
if [[ $(id -u) == 0 && ($there == "" || $there == not-installed) ]]; then
  # Minimal systems tell dpkg to leave manual pages and documents out.
  installed=yes
  dpkg --path-include='/usr/share/man/*' --path-include='/usr/share/doc/catan/*' --install "$package" >"$scratch/log" 2>&1 ||
    { cat "$scratch/log" >&2; exit 1; }
  root=
else
  echo "unpacked, not installed: this needs root, and no package catan"
  dpkg-deb --extract "$package" "$root"
fi
catan=$root/usr/bin/catan

# Its programs and libraries need nothing but libraries of packages that it depends on, so no OpenCV. This machine may have
# more than these, so that they would run here all the same.
dpkg-deb --extract "$package" "$scratch/content"
mapfile -t depends < <(dpkg-deb --field "$package" Pre-Depends Depends | sed 's/^[A-Za-z-]*: //' |
  tr ',|' '\n' | sed 's/[(:].*//; s/ //g; /^$/d')
apt-cache depends --recurse --installed --important "${depends[@]}" | grep -o '^[a-z0-9][^ :]*' | sort -u >"$scratch/closure"
binaries=0
while read -r file; do
  ldd "$file" >"$scratch/ldd" 2>/dev/null || continue # no program, no shared library
  binaries=$((binaries + 1))
  while read -r library; do
    [[ $library == /* ]] || fail "$file needs $library, which is not to be found"
    real=$(realpath "$library")
    owners=$({ dpkg-query --search "$library" "/usr$library" "$real" "${real#/usr}" 2>/dev/null || true; } |
      sed 's/[:,].*//' | sort -u)
    grep -qxF -f <(echo "${owners:-none}") "$scratch/closure" ||
      fail "${file#"$scratch/content"} needs $library of package ${owners:-none}, on which the package does not depend"
  done < <(sed -n 's/.* => \(not found\|[^ ]*\).*/\1/p' "$scratch/ldd")
done < <(find "$scratch/content/usr/bin" "$scratch/content/usr/lib" -type f)
[[ $binaries -ge 2 ]] || fail "the command and the library were not looked at"
"$catan" --version
examples=$root/usr/share/doc/catan/examples/navigation
"$catan" plan "$examples/navigation.yaml" --costs "$examples/navigation.costs.yaml" --cores 2 >"$scratch/plan"
grep -q objective "$scratch/plan" || fail "catan plan printed no plan"

# Manual pages: one of the command, one of each subcommand.
while read -r command; do
  page=$root/usr/share/man/man1/catan-$command.1.gz
  [[ -e $page ]] || fail "there is no manual page of catan $command"
  man -l "$page" 2>"$scratch/log" | grep -q SYNOPSIS || fail "the manual page of catan $command cannot be shown"
  [[ ! -s $scratch/log ]] || { cat "$scratch/log" >&2; fail "the manual page of catan $command has mistakes"; }
done < <("$catan" --help | sed -n '/^Subcommands:/,/^$/s/^  \([a-z]\{1,\}\) .*/\1/p')
man -l "$root/usr/share/man/man1/catan.1.gz" | grep -q 'catan doctor' || fail "catan(1) does not name the subcommands"

# Pages that --help names.
while read -r page; do
  [[ -e $root/usr/share/doc/catan/$page ]] || fail "--help names $page, which the package has not got"
done < <({ "$catan" --help; for c in bench check doctor plan run serve node ctl top http report sim whatif; do "$catan" "$c" --help; done; } |
  grep -o 'docs/[a-z-]*\.md' | sort -u)

# Completion, as bash calls it.
completion=$root/usr/share/bash-completion/completions/catan
bash -n "$completion"
complete_words() { # WORD...: what completes the last one
  PATH=$root/usr/bin:$PATH bash -c 'source "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _catan; printf "%s\n" "${COMPREPLY[@]}"' \
    _ "$completion" "$@" | sort | paste -sd' '
}
expect() { # WANTED WORD...
  local wanted=$1 got
  shift
  got=$(complete_words "$@")
  [[ $got == "$wanted" ]] || fail "'$*' was completed to '$got', not to '$wanted'"
}
expect doctor catan do
expect --explain catan plan --exp
expect paper catan plan --planner pa
expect "$scratch/plan" catan check "$scratch/pl"

# The library, from C, where there is a compiler.
if command -v cc >/dev/null && command -v pkg-config >/dev/null; then
  export PKG_CONFIG_PATH=$root/usr/lib/pkgconfig LD_LIBRARY_PATH=$root/usr/lib
  # shellcheck disable=SC2046
  cc -std=c99 examples/c/main.c $(pkg-config --cflags --libs catan) -o "$scratch/node"
  (cd examples/c && PATH=$root/usr/bin:$PATH catan run app.yaml --seconds 0.5 -- "$scratch/node" >/dev/null)
else
  echo "skipped: there is no C compiler, or no pkg-config, to use the library with"
fi

if [[ -n $installed ]]; then
  dpkg --purge catan >/dev/null
  installed=
  [[ ! -e /usr/bin/catan && ! -e /usr/include/catan && ! -e /usr/share/doc/catan ]] || fail "it left files behind"
fi
echo "the package can be installed, used and removed"
