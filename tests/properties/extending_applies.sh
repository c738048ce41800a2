#!/bin/sh
# SPDX-License-Identifier: MIT
# The diffs of docs/extending.md apply to the tree: each alone, and all of them in the order of the page.
# tests/properties/extending.sh builds and runs the result.
#   usage: extending_applies.sh SOURCE_DIR WORK_DIR
set -eu
source=$(cd "$1" && pwd) work=$2
rm -rf "$work"
mkdir -p "$work/tree"
work=$(cd "$work" && pwd)
export GIT_CEILING_DIRECTORIES="${work%/*}" # the copy must not count as part of a checkout around it
fail() { echo "FAILED: $1"; exit 1; }

diffs=$(sed -n 's/^git apply \(docs\/extending\/[a-z]*\.diff\)$/\1/p' "$source/docs/extending.md")
for diff in "$source"/docs/extending/*.diff; do
  case $diffs in
    *"docs/extending/${diff##*/}"*) ;;
    *) fail "docs/extending.md does not say: git apply docs/extending/${diff##*/}" ;;
  esac
done

for diff in $diffs; do
  [ -f "$source/$diff" ] || fail "docs/extending.md names $diff, which does not exist"
done

# The section of a diff ends at the next heading.
section() { awk -v diff="$1" '/^## /{text = ""; found = 0} {text = text $0 "\n"} index($0, "git apply " diff){found = 1}
  found{last = text} END{printf "%s", last}' "$source/docs/extending.md"; }
names() { section "$1" | grep -qF "\`$2\`"; }
for diff in $diffs; do
  for file in $(sed -n 's|^+++ b/||p' "$source/$diff"); do
    names "$diff" "$file" || fail "the section of docs/extending.md on ${diff##*/} does not name $file"
  done
done
! names docs/extending/plant.diff trainer/learn/losses/terms.h || fail "control: the section on plants names a loss"

# Applying needs only the files that the diffs change. Inside the folder of a checkout, git would skip files outside of
# it.
cd "$work"
for diff in $diffs; do git apply --numstat "$source/$diff" | cut -f 3; done | sort -u | while read -r file; do
  [ -f "$source/$file" ] || continue
  mkdir -p "$work/tree/$(dirname "$file")"
  cp "$source/$file" "$work/tree/$file"
done

cd "$work/tree"
remedy="apply what is left of it by hand (git apply --reject), and write the diff again"
for diff in $diffs; do
  git apply --check "$source/$diff" || fail "$diff does not apply any more; $remedy"
done
count=0
for diff in $diffs; do
  git apply "$source/$diff" || fail "$diff does not apply behind those before it; $remedy"
  ! git apply --check "$source/$diff" 2>/dev/null || fail "control: $diff applies twice"
  count=$((count + 1))
done
[ "$count" -eq 11 ] || fail "docs/extending.md should have eleven diffs, and has $count"
echo "$count diffs apply, each alone and all in order"
