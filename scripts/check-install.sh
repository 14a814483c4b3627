#!/usr/bin/env bash
# Installs a build into a scratch folder, then builds and runs a program against it, as a user of Catan would.
#   scripts/check-install.sh BUILD
set -euo pipefail
cd "$(dirname "$0")/.."
build=${1:?usage: scripts/check-install.sh BUILD}
scratch=$(mktemp -d)
trap 'rm -rf "$scratch"' EXIT
cmake --install "$build" --prefix "$scratch/prefix" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/prefix/bin/catan" --version
cmake -S tests/install -B "$scratch/user" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" --log-level=WARNING >/dev/null
cmake --build "$scratch/user" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
"$scratch/user/user" tests/install/app.yaml

# The examples, each as a project of its own.
export PATH="$scratch/prefix/bin:$PATH"
for example in node session c; do
  cp -r "examples/$example" "$scratch/$example"
  cmake -S "$scratch/$example" -B "$scratch/$example/build" -G Ninja -DCMAKE_PREFIX_PATH="$scratch/prefix" \
    --log-level=WARNING >/dev/null
  cmake --build "$scratch/$example/build" >"$scratch/log" || { cat "$scratch/log" >&2; exit 1; }
done
(cd "$scratch/node" && catan run app.yaml --seconds 1 -- ./start.sh build)
(cd "$scratch/session" && build/session app.yaml)
(cd "$scratch/c" && catan run app.yaml --seconds 1 -- build/node)
if command -v pkg-config >/dev/null; then
  library=$(dirname "$(find "$scratch/prefix" -name libcatan.so)")
  flags=$(PKG_CONFIG_PATH="$library/pkgconfig" pkg-config --cflags --libs catan)
  # shellcheck disable=SC2086
  cc -std=c99 -pedantic -Wall -Werror "$scratch/c/main.c" $flags -o "$scratch/c/by-pkg-config"
  (cd "$scratch/c" && LD_LIBRARY_PATH="$library" catan run app.yaml --seconds 0.5 -- ./by-pkg-config)
else
  echo "skipped: there is no pkg-config"
fi
