#!/usr/bin/env bash
# A server that comes back with another app file does not get the programs of the one before, and they say why, once:
# another_file_test.sh CATAN APPS
set -euo pipefail
catan=$1
apps=$2
folder=$(mktemp -d)
trap 'jobs=$(jobs -p); [ -z "$jobs" ] || kill -KILL $jobs 2>/dev/null; rm -rf "$folder"' EXIT
cd "$folder"
cp "$apps/one_node.yaml" app.yaml

"$catan" serve app.yaml --socket ./socket 2>first &
server=$!
"$catan" node app.yaml loop --synthetic "$apps/one_node.costs.yaml" --socket ./socket 2>said &
node=$!
eventually() { # eventually TEXT FILE
  for _ in $(seq 100); do
    if grep -q "$1" "$2"; then return; fi
    sleep 0.1
  done
  echo "not said in 10 s: $1"
  cat "$2"
  exit 1
}
eventually "have registered" first
kill -KILL $server
wait $server || true
eventually "it is gone" said

echo "# changed" >>app.yaml
"$catan" serve app.yaml --socket ./socket 2>second &
server=$!
eventually "nodes go on without it" said
sleep 1
[ "$(grep -c "nodes go on without it" said)" = 1 ]
if grep -q "have registered" second; then exit 1; fi
kill $node
wait $node
kill $server
wait $server
