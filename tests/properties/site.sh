#!/bin/sh
# SPDX-License-Identifier: MIT
# The docs as a site (docs/site.py): the site and its search contain each page of docs/README.md, and a broken link is
# an error.
#   site.sh SOURCES SCRATCH
set -eu
sources=$1 scratch=$2
rm -rf "$scratch"
mkdir -p "$scratch/tree"
"$sources/docs/site.py" -o "$scratch/site"
version=$(ls "$scratch/site" | grep '^[0-9]')
for page in index docs/tutorial docs/results docs/appendix/performance api/kkl__observer_8h; do
  [ -s "$scratch/site/$version/$page.html" ] || { echo "no $page.html" && exit 1; }
done
grep -q 'docs/choosing.html' "$scratch/site/$version/search/search_index.json"
grep -q 'Kazantzis-Kravaris' "$scratch/site/$version/api/kkl__observer_8h.html" # the comment at the top of a header

cp -r "$sources"/*.md "$sources"/*.py "$sources"/*.json "$sources/CMakeLists.txt" "$sources/docs" "$sources/toolchains" "$scratch/tree"
for part in runtime trainer codegen tests bench examples; do ln -sfn "$sources/$part" "$scratch/tree/$part"; done
echo '[gone](gone.md)' >>"$scratch/tree/docs/tutorial.md"
if "$scratch/tree/docs/site.py" -o "$scratch/broken" >"$scratch/said"; then echo 'a broken link was not detected' && exit 1; fi
"$scratch/tree/docs/site.py" -o "$scratch/broken" 2>&1 | grep -q 'docs/tutorial.md: gone.md is not in the tree'
