# Settings that our own targets link to privately. They are never installed or exported: a user's flags are the user's.

add_library(nlo_warnings INTERFACE)
target_compile_options(nlo_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> # GCC 12 misreads "literal" + std::string (its bug 105651)
  $<$<BOOL:${NLO_WARNINGS_AS_ERRORS}>:-Werror>)

# Fast code for the machine that trains. -ffp-contract is left at the compiler's default: the bytes of a run are
# reproducible on one build, not across instruction sets.
add_library(nlo_native INTERFACE)
if(NLO_NATIVE)
  target_compile_options(nlo_native INTERFACE -march=native)
  # GCC 12 misreads Eigen's vector loads (AVX: array-bounds; AVX-512: (maybe-)uninitialized). clang++ and the builds
  # without this target keep looking.
  target_compile_options(nlo_native INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-maybe-uninitialized;-Wno-uninitialized;-Wno-stringop-overflow;-Wno-stringop-overread>)
endif()

# Most of the time of a compilation goes into reading Eigen and the standard library: a precompiled header halves it.
# Sources include what they use all the same; CMAKE_DISABLE_PRECOMPILE_HEADERS (./test.sh --full) holds them to it.
function(nlo_precompile_common_headers target)
  target_precompile_headers(${target} PRIVATE
    <Eigen/Core> <algorithm> <cmath> <cstdint> <filesystem> <functional> <map> <optional> <string> <string_view> <vector>)
endfunction()

# nlo_optimise(TARGET [HOT sources...]): -O3 where a run spends its time, -O1 for all that reads, checks and prints: that
# is most of the code, and -O1 takes 40 % less time to compile than -O3. Debug builds (sanitizers): -O1 and none, for the
# same reason.
function(nlo_optimise target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "HOT")
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
  set_source_files_properties(${arg_HOT} PROPERTIES
    COMPILE_OPTIONS "$<$<CONFIG:Release>:-O3>;$<$<CONFIG:Debug>:-O1>" SKIP_PRECOMPILE_HEADERS ON)
endfunction()
