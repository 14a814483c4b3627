#!/usr/bin/env bash
# Runs every fuzzer of a fuzz build for some seconds each, as many at a time as there are CPUs.
#   scripts/fuzz.sh BUILD [SECONDS [JOBS]]
# A fuzzer is a program NAME_fuzzer below BUILD/fuzz; its seeds are in fuzz/corpus/NAME_fuzzer, its dictionary, if it has
# one, is fuzz/NAME_fuzzer.dict or else fuzz/yaml.dict. What it finds interesting goes to out/fuzz/NAME_fuzzer, and so does
# an input that breaks it: seeds change only on purpose.
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/fuzz.sh BUILD [SECONDS]}
seconds=${2:-20}
jobs=${3:-$(nproc)}

# The fuzzer $1 for $2 seconds.
run() {
  local fuzzer=$1 seconds=$2 name work seeds=() dictionary log
  name=$(basename "$fuzzer")
  work=out/fuzz/$name
  mkdir -p "$work"
  [[ -d fuzz/corpus/$name ]] && seeds=("fuzz/corpus/$name")
  dictionary=fuzz/$name.dict
  [[ -e $dictionary ]] || dictionary=fuzz/yaml.dict
  log=out/fuzz/$name.log
  # A hang is an error too: no input of 64 KiB at most may take 5 s.
  if "$fuzzer" -max_total_time="$seconds" -timeout=5 -rss_limit_mb=2048 -max_len=65536 -print_final_stats=1 \
      -dict="$dictionary" -artifact_prefix="$work/broken-" "$work" "${seeds[@]}" >"$log" 2>&1; then
    echo "$name: $(sed -n 's/^stat::number_of_executed_units: *//p' "$log") inputs in $seconds s, nothing found"
  else
    printf '%s: FOUND SOMETHING; the end of %s:\n%s\n' "$name" "$log" "$(tail -n 30 "$log")"
    return 1
  fi
}
export -f run

mapfile -t fuzzers < <(find "$build/fuzz" -type f -name '*_fuzzer' -perm -u+x | sort)
[[ ${#fuzzers[@]} -gt 0 ]] || { echo "fuzz: there are no fuzzers in $build/fuzz"; exit 1; }
printf '%s\0' "${fuzzers[@]}" | xargs -0 -P "$jobs" -I '{}' bash -c 'run "$@"' _ '{}' "$seconds"
