#!/usr/bin/env bash
# Installs the Debian 12 packages that Catan needs. Says nothing where none is missing; safe to run again at any time.
#
#   scripts/setup.sh           what building, testing and the demo need
#   scripts/setup.sh --dev     that, and what formatting, linting, fuzzing and packaging need (--ci is the same)
#   scripts/setup.sh --ros1    that of users, and what the port to ROS 1 needs; may stand beside --dev
#   scripts/setup.sh --list    only prints the names of the packages
#
# Exit: 0 all there, 1 something is missing and could not be installed, 2 a wrong option.
set -euo pipefail

user_packages=(
  g++                    # the compiler
  make                   # the Makefile's targets
  cmake                  # the build
  ninja-build            # runs it
  ccache                 # makes the second build fast
  libfmt-dev             # formatted text
  nlohmann-json3-dev     # JSON: plans, results
  libyaml-cpp-dev        # YAML: app and cost files
  libcli11-dev           # command lines
  libsqlite3-dev         # records of runs
  libncurses-dev         # the screen of catan top
  libprotobuf-dev        # traces for Perfetto
  protobuf-compiler      # and the classes of their format
  libeigen3-dev          # linear algebra of the planner
  libcpp-httplib-dev     # the page and metrics of a server
  sqlite3                # reads a record from a shell, as docs/record-schema.md shows
  libopencv-dev          # cameras and detectors of the case studies; its package config wants all of OpenCV's modules, so none of the parts
  opencv-data            # the face detector's cascades
  opencv-doc             # films with real faces, for that app, and of people, for the navigation app
  libbox2d-dev           # rays and contact in the simulated world of the navigation app
  libmrpt-maps-dev       # occupancy grids of the navigation app; of MRPT the smallest package that has them
  libegl-dev             # the VR app draws without a window: headers of EGL
  libgles-dev            # and of OpenGL ES
  libegl-mesa0           # the driver, which needs no GPU
  libgl1-mesa-dri        # and what it draws with
  libgtest-dev           # unit tests
  libgmock-dev           # their matchers
  librapidcheck-dev      # property tests
  libbenchmark-dev       # make bench
  gnuplot-nox            # plots
  python3                # tests of examples/python, and of what docs/export.md does with a record
)
dev_packages=(
  git                    # what lint and format look at
  clang-14               # the compiler of tests under sanitizers, and of fuzzers
  libclang-rt-14-dev     # its sanitizers and libFuzzer
  clang-format-14        # make format
  clang-tidy-14          # make lint
  cppcheck               # make lint
  dpkg-dev               # make package
  file                   # which asks it what a library is
  help2man               # writes its manual pages
  man-db                 # whose check shows them
  pkg-config             # and compiles a program against the package
)
ros1_packages=(
  libroscpp-dev          # roscpp
  libstd-msgs-dev        # messages of the tests' programs
  libgeometry-msgs-dev   # those that have a stamp; velocities and poses of the navigation app
  libnav-msgs-dev        # its odometry
  libsensor-msgs-dev     # its scans
  libdiagnostic-msgs-dev # what catan ros node publishes
  libdynamic-reconfigure-config-init-mutex-dev # and how settings are changed
  libmessage-filters-dev # its synchronizers, in a test
  libnodelet-dev         # nodelets, in a test
  libnodeletlib-dev
  python3-rosbag         # recorded sensors, in a test
  python3-rospy          # a node in Python, in a test
  python3-std-msgs
  python3-roslaunch      # roscore, roslaunch
  python3-rosmaster      # the master
)
# A file of opencv-doc that the apps need. Minimal systems tell dpkg to leave /usr/share/doc out.
doc_data=/usr/share/doc/opencv-doc/examples/data
doc_sample=$doc_data/Megamind.avi
keep_doc_data=(-o "DPkg::Options::=--path-include=/usr/share/doc/opencv-doc/*")

say() { printf 'setup: %s\n' "$*" >&2; }

packages=("${user_packages[@]}")
list_only=0
for option in "$@"; do
  case $option in
    --dev | --ci) packages+=("${dev_packages[@]}") ;;
    --ros1) packages+=("${ros1_packages[@]}") ;;
    --list) list_only=1 ;;
    -h | --help) sed -n '2,10s/^# \{0,1\}//p' "$0"; exit 0 ;;
    *) say "unknown option '$option'; try --help"; exit 2 ;;
  esac
done
if [[ $list_only == 1 ]]; then
  printf '%s\n' "${packages[@]}"
  exit 0
fi

missing=("${packages[@]}")
if command -v dpkg-query >/dev/null; then
  installed=$(dpkg-query -W -f='${db:Status-Status} ${Package}\n' "${packages[@]}" 2>/dev/null | sed -n 's/^installed //p' || true)
  mapfile -t missing < <(comm -23 <(printf '%s\n' "${packages[@]}" | sort -u) <(sort -u <<<"$installed"))
fi
reinstall=()
if [[ " ${missing[*]} " != *" opencv-doc "* && ! -e $doc_sample ]]; then
  reinstall=(opencv-doc)
fi
wanted=("${missing[@]}" "${reinstall[@]}")
[[ ${#wanted[@]} -gt 0 ]] || exit 0

system=$(. /etc/os-release 2>/dev/null && printf '%s %s' "${ID:-unknown}" "${VERSION_ID:-}" || printf 'unknown')
if [[ $system != "debian 12" ]] || ! command -v apt-get >/dev/null; then
  say "this is not Debian 12 (found: $system), where Catan is built and tested. These of its packages are missing here:"
  say "  ${wanted[*]}"
  say "Install them, or what they are called here, and run make with SETUP=skip."
  exit 1
fi

as_root=()
if [[ $(id -u) != 0 ]]; then
  # Without a terminal sudo cannot ask for a password, so it must not need one.
  if command -v sudo >/dev/null && { [[ -t 0 ]] || sudo -n true 2>/dev/null; }; then
    as_root=(sudo)
  else
    say "packages are missing, and installing them needs root (there is no sudo that works here). As root:"
    say "  apt-get install --no-install-recommends -o '${keep_doc_data[1]}' ${reinstall:+--reinstall }${wanted[*]}"
    exit 1
  fi
fi

log=$(mktemp)
trap 'rm -f "$log"' EXIT
apt() {
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get -qq -y -o Acquire::Retries=3 -o DPkg::Lock::Timeout=300 \
    -o Dpkg::Use-Pty=0 "$@" </dev/null >>"$log" 2>&1
}
[[ ${#as_root[@]} == 0 ]] || "${as_root[@]}" -v -p "setup: password of %p, to install packages: " || exit 1

say "installing ${#wanted[@]} packages: ${wanted[*]}"
started=$SECONDS
apt update || say "the package lists could not be refreshed; trying with those that are here"
if { [[ ${#missing[@]} == 0 ]] || apt install --no-install-recommends "${keep_doc_data[@]}" "${missing[@]}"; } &&
   { [[ ${#reinstall[@]} == 0 ]] || apt install --reinstall --no-install-recommends "${keep_doc_data[@]}" "${reinstall[@]}"; }; then
  say "done in $((SECONDS - started)) s"
else
  tail -n 15 "$log" >&2
  say "the packages could not be installed (above: the end of apt-get's output)"
  exit 1
fi
if [[ ! -e $doc_sample ]]; then
  say "opencv-doc is installed, but $doc_sample is not there; does dpkg leave out /usr/share/doc?"
  exit 1
fi
