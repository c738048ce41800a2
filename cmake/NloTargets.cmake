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

# -O1 for all that reads, checks and prints: that is most of the code, and takes 40 % less time to compile than -O3.
function(nlo_optimise target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# nlo_hot_sources(TARGET SOURCES...): sources of a folder where a run spends its time. -O3; -O1 in Debug builds
# (sanitizers), where the others have none.
function(nlo_hot_sources target)
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE sources)
  target_sources(${target} PRIVATE ${sources})
  set_source_files_properties(${sources} TARGET_DIRECTORY ${target} PROPERTIES
    COMPILE_OPTIONS "$<$<CONFIG:Release>:-O3>;$<$<CONFIG:Debug>:-O1>" SKIP_PRECOMPILE_HEADERS ON)
endfunction()
