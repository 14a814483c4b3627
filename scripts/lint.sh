#!/usr/bin/env bash
# Static analysis of all that is ours, with the compile commands of a configured build folder.
#   scripts/lint.sh BUILD [JOBS]
# Test programs and fuzzers are left out: their macros expand to what clang-tidy's checks are against.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/lint.sh BUILD [JOBS]}
jobs=${2:-$(nproc)}
failed=0

mapfile -t sources < <(git ls-files 'src/*.cpp' 'apps/*.cpp' 'tools/*.cpp' 'integrations/*.cpp' | grep -v '_test\.cpp$')
echo "clang-tidy: ${#sources[@]} files"
if [[ ${#sources[@]} -gt 0 ]]; then
  # It counts the warnings it suppressed in others' headers, which is no news. Compile commands may have options for
  # warnings that only GCC knows.
  printf '%s\0' "${sources[@]}" | xargs -0 -P "$jobs" -n 4 clang-tidy-14 -quiet -p "$build" \
    --extra-arg=-Wno-unknown-warning-option 2>&1 |
    { grep -vE '^[0-9]+ warnings? (generated|and)|^$' || true; } ||
    { failed=1; echo "clang-tidy: found something"; }
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
