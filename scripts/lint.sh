#!/usr/bin/env bash
# Static analysis of the modules, apps, tools and integrations, with the compile commands of a configured build folder.
#   scripts/lint.sh BUILD [JOBS]             all of these
#   scripts/lint.sh --changed BUILD [JOBS]   files that differ from origin/main, or from the last commit where there is none
# Test programs, fuzzers, benchmarks and examples are left out: the macros of most of them expand to what clang-tidy's
# checks are against.
#
# Most of clang-tidy's time goes into reading headers, so all modules are looked at as one source, so are all tools, and so on
# (catan_as_one in CMakeLists.txt). --changed looks at each file by itself, which also tells whether it includes all that it
# needs.
set -euo pipefail
cd "$(dirname "$0")/.."
changed=
if [[ ${1:-} == --changed ]]; then
  changed=yes
  shift
fi
build=${1:?usage: scripts/lint.sh [--changed] BUILD [JOBS]}
jobs=${2:-$(nproc)}
failed=0

mapfile -t sources < <(git ls-files 'src/*.cpp' 'apps/*.cpp' 'tools/*.cpp' 'integrations/*.cpp' | grep -v '_test\.cpp$')
pieces=()  # sources of BUILD that include several of ours
covered=() # those that they include
if [[ -n $changed ]]; then
  since=$(git merge-base HEAD origin/main 2>/dev/null || git rev-parse HEAD~1)
  [[ $since != "$(git rev-parse HEAD)" ]] || since=HEAD~1
  mapfile -t different < <(git diff --name-only --diff-filter=d "$since" -- '*.cpp' '*.h')
  # Of a header, the source that has its name; where there is none, one that includes it.
  mapfile -t sources < <(for file in "${different[@]}"; do
    source=${file/%.h/.cpp}
    [[ -e $source ]] || source=$(git grep -lE "^#include \"(.*/)?${file##*/}\"" -- "${sources[@]}" | head -n 1 || true)
    echo "$source"
  done | sort -u | comm -12 - <(printf '%s\n' "${sources[@]}" | sort))
else
  mapfile -t pieces < <(sed -n 's/^ *"file": "\(.*\/Unity\/.*\)".*/\1/p' "$build/compile_commands.json" |
    grep -E '/all_[a-z_]*\.dir/' | sort)
  if [[ ${#pieces[@]} -gt 0 ]]; then
    mapfile -t covered < <(sed -n "s|^#include \"$PWD/\(.*\.cpp\)\"|\1|p" "${pieces[@]}")
  fi
fi
mapfile -t single < <(printf '%s\n' "${sources[@]}" | sort -u | comm -23 - <(printf '%s\n' "${covered[@]}" | sort -u) | grep .)

# Compile commands of files that are compiled one by one.
if [[ ${#single[@]} -gt 0 ]]; then
  cmake --preset ci -B "$build/lint" -DCATAN_UNITY=OFF --log-level=WARNING >/dev/null
  # What is for frameworks that are not here cannot be compiled.
  mapfile -t compiled < <(sed -n "s|^ *\"file\": \"$PWD/\(.*\)\".*|\1|p" "$build/lint/compile_commands.json")
  mapfile -t foreign < <(printf '%s\n' "${single[@]}" | grep '^integrations/' | comm -23 - <(printf '%s\n' "${compiled[@]}" | sort -u))
  [[ ${#foreign[@]} == 0 ]] || echo "clang-tidy: left out, since this build does not compile them: ${foreign[*]}"
  mapfile -t single < <(printf '%s\n' "${single[@]}" | comm -23 - <(printf '%s\n' "${foreign[@]}") | grep .)
fi

# tidy DATABASE OPTION... -- FILE...
tidy() {
  local database=$1 options=()
  shift
  while [[ $1 != -- ]]; do
    options+=("$1")
    shift
  done
  shift
  # It counts the warnings it suppressed in others' headers, which is no news. Compile commands may have options that only
  # GCC knows.
  printf '%s\0' "$@" | xargs -0 -P "$jobs" -n 1 clang-tidy-14 -quiet -p "$database" "${options[@]}" \
    --extra-arg-before=-I"$PWD/scripts/lint" --extra-arg=-Wno-unknown-warning-option --extra-arg=-Wno-unused-command-line-argument 2>&1 |
    { grep -vE '^[0-9]+ warnings? (generated|and)|^$' || true; }
}

echo "clang-tidy: ${#sources[@]} files, ${#covered[@]} of them in ${#pieces[@]} pieces"
if [[ ${#pieces[@]} -gt 0 ]]; then
  # A piece includes sources, and that is where to look. Where a library declares a name that a source of ours has, too,
  # the check of forward declarations takes one for the other.
  tidy "$build" --checks=-bugprone-suspicious-include,-bugprone-forward-declaration-namespace --header-filter='/(src|include|apps|tools|integrations)/.*\.(h|cpp)$' \
    -- "${pieces[@]}" || { failed=1; echo "clang-tidy: found something (a redefinition: the names of helpers must differ in a piece)"; }
fi
if [[ ${#single[@]} -gt 0 ]]; then
  tidy "$build/lint" -- "${single[@]}" || { failed=1; echo "clang-tidy: found something"; }
fi

# cppcheck, too, cannot parse the tests' macros. What it says about performance clang-tidy says better.
echo "cppcheck: ${#sources[@]} files"
if [[ ${#sources[@]} -gt 0 ]]; then
  mkdir -p "$build/cppcheck"
  cppcheck --quiet --std=c++20 --language=c++ --enable=warning,portability --inline-suppr --error-exitcode=1 \
    --suppress=virtualCallInConstructor -I src -I include -j "$jobs" --cppcheck-build-dir="$build/cppcheck" \
    "${sources[@]}" || { failed=1; echo "cppcheck: found something"; }
fi
exit $failed
