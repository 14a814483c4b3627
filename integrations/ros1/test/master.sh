# shellcheck shell=bash
# For the scripts beside it, which source it: a folder, $home, that is gone with them, and a ROS master on a port of its
# own, which all commands of theirs find.
home=$(mktemp -d)
trap 'kill "$master" 2>/dev/null && wait "$master" || true; rm -rf "$home"' EXIT
port=$(/usr/bin/python3 -c 'import socket; s = socket.socket(); s.bind(("localhost", 0)); print(s.getsockname()[1])')
export HOME=$home ROS_HOME=$home ROS_LOG_DIR=$home ROS_HOSTNAME=localhost ROS_MASTER_URI=http://localhost:$port
PYTHONUNBUFFERED=1 /usr/bin/python3 /usr/bin/roscore -p "$port" >"$home/roscore.log" 2>&1 &
master=$!
for ((tries = 0; tries < 400; tries++)); do
  grep -q 'started core service' "$home/roscore.log" && break
  sleep 0.05
done
