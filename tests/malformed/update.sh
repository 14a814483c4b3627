#!/bin/sh
# Writes what the command says now into every .expected: update.sh PATH/TO/catan. Read the diff before you commit it.
set -u
catan=$(realpath "$1")
cd "$(dirname "$0")" || exit 1
for file in app/*.yaml; do
  "$catan" check "$file" 2> "${file%.yaml}.expected" > /dev/null
done
for file in costs/*.yaml; do
  "$catan" check costs.app.yaml --costs "$file" 2> "${file%.yaml}.expected" > /dev/null
done
