# SPDX-License-Identifier: MIT
# Source this file in scripts that link programs and need the stack of their calls.

# Prints the deepest path of the call graph below step_and_estimate [bytes], from GCC's .ci file. Calls that it cannot
# follow (libm, libgcc) count as 0. The measured stack includes them.
stack_bound() {
  awk -F'"' '
    /^node:/ { if (match($4, /[0-9]+ bytes/)) size[$2] = substr($4, RSTART, RLENGTH) + 0 }
    /^edge:/ { calls[$2] = calls[$2] SUBSEP $4 }
    function depth(f,    list, n, i, d, most) {
      n = split(calls[f], list, SUBSEP)
      for (i = 2; i <= n; ++i) if ((d = depth(list[i])) > most) most = d
      return size[f] + most
    }
    END { print depth("step_and_estimate") }' "$1"
}
