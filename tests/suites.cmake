# Run by ctest before it starts: one entry for each suite of a program. One for each test would start the programs
# over a thousand times, and most of that time is the loading of a program.
#   program, sources, labels, long  of nlo_add_test; `long` lists tests that this build leaves out
set(suites "")
foreach(source IN LISTS sources)
  file(STRINGS ${source} lines REGEX "^(TYPED_)?TEST(_F|_P)?\\(")
  foreach(line IN LISTS lines)
    string(REGEX REPLACE "^[A-Z_]+\\( *([A-Za-z0-9_]+).*" "\\1" suite "${line}")
    list(APPEND suites ${suite})
  endforeach()
endforeach()
list(REMOVE_DUPLICATES suites)

set(others "")
string(REPLACE ";" ":" left_out "${long}")
foreach(suite IN LISTS suites)
  set(all_of "${suite}.*:${suite}/*:*/${suite}.*") # plain, typed, with parameters
  add_test(${name}.${suite} ${program} --gtest_brief=1 "--gtest_filter=${all_of}:-${left_out}")
  list(APPEND registered ${name}.${suite})
  string(APPEND others ":${all_of}")
endforeach()
set_tests_properties(${registered} PROPERTIES LABELS "${labels}" TIMEOUT 600)

# A suite that was not seen above (a macro of one's own around TEST) would be lost without a word.
add_test(${name}.no_other_suite ${program} "--gtest_filter=-${others}")
set_tests_properties(${name}.no_other_suite PROPERTIES LABELS "${labels}" TIMEOUT 60
  PASS_REGULAR_EXPRESSION "Running 0 tests")
unset(registered)
