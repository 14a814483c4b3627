#!/usr/bin/env bash
# Does what docs/ros1.md tells its reader to: tutorial.sh RUN PAGE CATAN NODES, where RUN is the script that runs a
# page's commands, CATAN and NODES the folders of the command and of the page's ROS programs. There is a master, on a
# port of its own; measurements take a second in place of as long as the page says, and plans are searched for less.
set -euo pipefail
run=$1 page=$2 catan=$3 nodes=$4
home=$(mktemp -d)
trap 'kill "$master" 2>/dev/null && wait "$master" || true; rm -rf "$home"' EXIT
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("localhost", 0)); print(s.getsockname()[1])')
export HOME=$home ROS_HOME=$home ROS_LOG_DIR=$home ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port
export PATH=$catan:$nodes:/usr/bin:$PATH
PYTHONUNBUFFERED=1 /usr/bin/python3 /usr/bin/roscore -p "$port" >"$home/roscore.log" 2>&1 &
master=$!
for ((tries = 0; tries < 400; tries++)); do
  grep -q 'started core service' "$home/roscore.log" && break
  sleep 0.05
done
sed -E 's/--seconds [0-9]+/--seconds 1/; s/^(catan plan .*)/\1 --effort 0.2/' "$page" >"$home/page.md"
"$run" "$home/page.md" "$home"
