#!/bin/sh
# SPDX-License-Identifier: MIT
# The six files that README names for the method exist, and have fewer than 1,000 lines together.
#   usage: six_files.sh SOURCE_DIR
set -eu
cd "$1"
files=$(awk '/^## / { inside = /How it works, in six files/ } inside' README.md | sed -n 's/^[0-9]*\. \[`[^`]*`\](\([^)]*\)).*/\1/p')
count=0 lines=0
for file in $files; do
  [ -f "$file" ] || { echo "FAILED: README names $file, which does not exist"; exit 1; }
  count=$((count + 1))
  lines=$((lines + $(wc -l <"$file")))
  echo "$(wc -l <"$file") $file"
done
echo "$count files, $lines lines"
[ "$count" -eq 6 ] || { echo "FAILED: README should name six files in its section \"How it works, in six files\""; exit 1; }
[ "$lines" -lt 1000 ] || { echo "FAILED: a newcomer reads at most 1,000 lines for the method"; exit 1; }
