# ctest reads this file before it starts: one entry for each suite of a program. With one entry for each test, programs
# would start over a thousand times, and most of their time would go into loading.
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

# This test fails for a suite that was not found above, for example behind a macro around TEST. Otherwise the suite
# would never run.
add_test(${name}.no_other_suite ${program} "--gtest_filter=-${others}")
set_tests_properties(${name}.no_other_suite PROPERTIES LABELS "${labels}" TIMEOUT 60
  PASS_REGULAR_EXPRESSION "Running 0 tests")
unset(registered)
