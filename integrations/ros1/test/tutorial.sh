#!/usr/bin/env bash
# Does what docs/ros1.md tells its reader to: tutorial.sh RUN PAGE CATAN NODES, where RUN is the script that runs a
# page's commands, CATAN and NODES the folders of the command and of the page's ROS programs. There is a master, on a
# port of its own; measurements take a second in place of as long as the page says, and plans are searched for less.
set -euo pipefail
run=$1 page=$2 catan=$3 nodes=$4
export PATH=$catan:$nodes:/usr/bin:$PATH
# shellcheck source=integrations/ros1/test/master.sh
source "$(dirname "$0")/master.sh"
sed -E 's/--seconds [0-9]+/--seconds 1/; s/^(catan plan .*)/\1 --effort 0.2/' "$page" >"$home/page.md"
"$run" "$home/page.md" "$home"
