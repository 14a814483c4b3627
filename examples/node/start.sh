#!/bin/sh
# Starts both nodes, and ends them when it is told to end: start.sh FOLDER-OF-NODE
"$1/node" camera & camera=$!
"$1/node" detect & detect=$!
trap 'kill $camera $detect' INT TERM
wait
wait
