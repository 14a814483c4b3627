#!/usr/bin/env bash
# Whether ROS programs are scheduled by what `cmake --install` puts into a folder, and by nothing of the build:
# installed.sh CMAKE BUILD NODE, where NODE is a ROS program that knows nothing of Catan.
set -euo pipefail
cmake=$1 build=$2 node=$3
# shellcheck source=integrations/ros1/test/master.sh
source "$(dirname "$0")/master.sh"
prefix=$home/prefix
# Without the demos, which have components of their own.
for component in Unspecified ros1; do
  "$cmake" --install "$build" --prefix "$prefix" --component "$component" >"$home/log" 2>&1 || {
    cat "$home/log" >&2
    exit 1
  }
done
export PATH=$prefix/bin:/usr/bin:/bin
cp "$node" "$home/node"
cd "$home"

fail() {
  echo "installed.sh: $1" >&2
  cat -- *.log >&2
  exit 1
}

cat >app.yaml <<'APP'
catan: 1
app: installed
nodes:
  source: { max_rate: 50Hz, fallback_rate: 50Hz, ros: { node: /source, timer: 50Hz } }
  sink: { ros: { node: /sink, topic: /data } }
edges: [ source -> sink ]
subchains: { both: [source, sink] }
objective: [ { response_time: [source, sink], weight: 1 } ]
APP
cat >launch.sh <<'LAUNCH'
echo "$LD_PRELOAD" >preloaded
./node source --timer 20 --out /data & source=$!
./node sink --in /data & sink=$!
trap 'kill $source $sink' TERM
wait
wait
LAUNCH
catan ros run app.yaml --seconds 3 --json -- sh launch.sh >report.json 2>run.log || fail "catan ros run does not run"
case $(cat preloaded) in
  "$prefix"/lib*/catan/libcatan_ros1_preload.so) ;;
  *) fail "$(cat preloaded) is loaded, which is not of the installation" ;;
esac
/usr/bin/python3 - <<'CHECK' || fail "the programs are not scheduled"
import json
runs = {node["node"]: node["runs"] for node in json.load(open("report.json"))["nodes"]}
assert runs["source"] > 20 and runs["sink"] > 20, runs
CHECK

# As a package of ROS: a server, which programs join, and the app as a node.
"$prefix/share/catan/catan_server" app.yaml --socket server __name:=catan_server >server.log 2>&1 &
server=$!
for ((tries = 0; tries < 200; tries++)); do
  [[ -S server ]] && break
  sleep 0.05
done
catan ros run app.yaml --socket server -- sh launch.sh >programs.log 2>&1 &
programs=$!
started=("$server" "$programs")
if ls "$prefix"/lib*/catan/libcatan_ros1_node.so "$prefix"/lib*/*/catan/libcatan_ros1_node.so >/dev/null 2>&1; then
  "$prefix/share/catan/catan_node" server __name:=catan >node.log 2>&1 &
  started+=($!)
fi
trap 'kill "${started[@]}" "$master" 2>/dev/null; wait || true; rm -rf "$home"' EXIT
/usr/bin/python3 - "${#started[@]}" <<'CHECK' || fail "the programs, or the app's own node, do not come"
import os, sys, time, xmlrpc.client
master = xmlrpc.client.ServerProxy(os.environ["ROS_MASTER_URI"])
wanted = ["/source", "/sink"] + (["/catan"] if sys.argv[1] == "3" else [])
until = time.monotonic() + 20
while any(master.lookupNode("/test", name)[0] != 1 for name in wanted):
    assert time.monotonic() < until, wanted
    time.sleep(0.1)
CHECK
for ((tries = 0; tries < 200; tries++)); do
  grep -q 'subchain both runs' server.log && exit 0
  sleep 0.1
done
fail "the server does not schedule the programs"
