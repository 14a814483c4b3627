#!/usr/bin/env bash
# Runs the tests of a build.
#   scripts/test.sh PRESET [JOBS [REGEX [LABEL]]]
# Only tests whose names match REGEX; without those that have LABEL, and those of programs that are not built where it is given.
# First all tests that depend on nothing but what they compute, JOBS at a time. Then, one by one, those with the label
# `realtime`, which run threads against the clock: another process that takes the CPU may make one of these fail. Such a test
# is run once more by itself. If it passes then, the run passes, but says so, and the test's name and what it printed are in
# out/ci/flaky.txt, and in out/flaky.txt with those of all runs before: that is a defect to work on. If it fails again, the
# run fails.
#   CATAN_REQUIRE_REALTIME=1   tests that skip themselves because they may not set real-time levels, or cannot draw, fail
#   CATAN_YOLO=FOLDER          the real network for tests that need one (docs/navigation-detector.md); otherwise they are skipped
#   SKIP_REALTIME=1            only those that do not depend on the clock
#   TMPDIR=FOLDER              where tests write their files; else in memory, or in /tmp where that has no room
set -euo pipefail
cd "$(dirname "$0")/.."
preset=${1:?usage: scripts/test.sh PRESET [JOBS [REGEX [LABEL]]]}
jobs=${2:-$(nproc)}
chosen=(--tests-regex "${3:-.}")
without=${4:-}
[[ -z $without ]] || chosen+=(--exclude-regex '_NOT_BUILT$')
log=build/$preset/Testing/Temporary
flaky=out/ci/flaky.txt
mkdir -p out/ci
failed=0
[[ -n ${CI:-} ]] || rm -f "$flaky" # .ci/run removes what is of a run before
rm -f "$log"/{steady,realtime,again}.{log,failed}

# Tests write thousands of small files, and a disk can take a millisecond for each. In memory they must have room, and
# programs must be allowed to run from there: some tests compile one. Prints the folder's name.
make_folder_in_memory() {
  local free folder
  free=$(df --output=avail -B1M /dev/shm 2>/dev/null | tail -n 1)
  [[ ${free:-0} -ge 1024 ]] && folder=$(mktemp -d /dev/shm/catan-tests-XXXXXX 2>/dev/null) || return 1
  echo "$folder"
  chmod 755 "$folder" # some tests act as another user
  cp /bin/true "$folder" && "$folder/true" 2>/dev/null && rm "$folder/true"
}
if [[ -z ${TMPDIR:-} ]]; then
  scratch=
  trap '[[ -z $scratch ]] || rm -rf "$scratch"' EXIT
  if scratch=$(make_folder_in_memory); then export TMPDIR=$scratch; fi
fi

# run NAME OPTION...: ctest; what all tests printed is kept as NAME.log, who failed as NAME.failed (lines NUMBER:TEST).
run() {
  local name=$1 status=0
  shift
  rm -f "$log/LastTestsFailed.log" "$log/LastTest.log"
  ctest --preset "$preset" "${chosen[@]}" "$@" || status=$?
  cp "$log/LastTest.log" "$log/$name.log" 2>/dev/null || : >"$log/$name.log"
  cp "$log/LastTestsFailed.log" "$log/$name.failed" 2>/dev/null || : >"$log/$name.failed"
  return $status
}

# What one test printed, from a log of ctest.
printed_by() { awk -v test="$2" '/^[0-9]+\/[0-9]+ Test(ing)?: /{on = ($3 == test)} on' "$1"; }

run steady --parallel "$jobs" --label-exclude "^realtime\$${without:+|^$without\$}" --no-tests=ignore || failed=1

if [[ -z ${SKIP_REALTIME:-} ]]; then
  if ! run realtime --label-regex '^realtime$' ${without:+--label-exclude "^$without\$"} --no-tests=ignore; then
    mapfile -t again < <(sed 's/^[0-9]*://' "$log/realtime.failed")
    [[ ${#again[@]} -gt 0 ]] || failed=1 # ctest itself failed
    for test in "${again[@]}"; do
      printf '\n== %s failed; once more, alone\n' "$test"
      chosen=(--tests-regex "^$(sed 's/[][\.*^$+?(){}|]/\\&/g' <<<"$test")\$")
      if run again --no-tests=error; then
        printf '\n!!! FLAKY: %s failed and then passed. Its first failure is in %s: a defect to work on.\n\n' "$test" "$flaky"
        { date -u '+======== %F %T UTC'; echo "$test (preset $preset)"; printed_by "$log/realtime.log" "$test"; } | tee -a out/flaky.txt >>"$flaky"
      else
        printf '\n== %s failed twice\n' "$test"
        failed=1
      fi
    done
  fi
fi

if ! grep -qs 'Testing: ' "$log"/{steady,realtime}.log; then
  echo "no test was run: does the name of one match '${3:-.}'?" >&2
  failed=1
fi
if [[ -n ${CATAN_REQUIRE_REALTIME:-} ]]; then
  lacking=$({ cat "$log/steady.log" "$log/realtime.log" 2>/dev/null || true; } |
    awk '/^[0-9]+\/[0-9]+ Test(ing)?: /{test = $3} /needs the permission to|EGL is not installed/{print test}' | sort -u)
  if [[ -n $lacking ]]; then
    printf '\n== skipped for lack of real-time levels or of EGL, which this run requires:\n%s\n' "$lacking"
    failed=1
  fi
fi
exit $failed
