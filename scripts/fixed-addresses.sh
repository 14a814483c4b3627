#!/usr/bin/env bash
# Runs a command without address-space randomisation: ThreadSanitizer, as clang 14 and GCC 12 have it, does not start where
# the kernel randomises more than 28 bits, as newer ones do. Containers may forbid it; then the command runs as it is, and says so.
set -eu
if setarch -R true 2>/dev/null; then exec setarch -R "$@"; fi
bits=$(cat /proc/sys/vm/mmap_rnd_bits 2>/dev/null || echo unknown)
echo "fixed-addresses: cannot turn address randomisation off here (vm.mmap_rnd_bits = $bits; ThreadSanitizer needs <= 28)" >&2
exec "$@"
