# Settings that our own targets link to privately. They are never installed or exported, because users choose their own flags.

add_library(nlo_warnings INTERFACE)
target_compile_options(nlo_warnings INTERFACE
  -Wall -Wextra -Wpedantic -Wconversion -Wdouble-promotion -Wshadow
  $<$<CXX_COMPILER_ID:GNU>:-Wno-restrict> # GCC 12 misreads "literal" + std::string (its bug 105651)
  $<$<BOOL:${NLO_WARNINGS_AS_ERRORS}>:-Werror>)

# Let GCC collect its garbage less often: this took 1 s of the 14 s for trainer/prove/forward_map.cpp.
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND PROJECT_IS_TOP_LEVEL)
  add_compile_options(--param=ggc-min-expand=300 --param=ggc-min-heapsize=524288)
endif()

# Fast code for the machine that trains. -ffp-contract is left at the compiler's default: the bytes of a run are
# reproducible on one build, not across instruction sets.
add_library(nlo_native INTERFACE)
if(NLO_NATIVE)
  target_compile_options(nlo_native INTERFACE -march=native)
  # GCC 12 misreads Eigen's vector loads (AVX: array-bounds; AVX-512: (maybe-)uninitialized). clang++ and the builds
  # without this target keep these warnings.
  target_compile_options(nlo_native INTERFACE
    $<$<CXX_COMPILER_ID:GNU>:-Wno-array-bounds;-Wno-maybe-uninitialized;-Wno-uninitialized;-Wno-stringop-overflow;-Wno-stringop-overread>)
else()
  target_compile_options(nlo_native INTERFACE -Wno-psabi) # vectors are only passed between sources with the same flags
endif()

# Most of the time of a compilation goes into reading Eigen and the standard library: a precompiled header halves it.
# Sources must still include what they use; ./test.sh --full checks this with CMAKE_DISABLE_PRECOMPILE_HEADERS.
function(nlo_precompile_common_headers target)
  target_precompile_headers(${target} PRIVATE
    <Eigen/Core> <algorithm> <cmath> <cstdint> <filesystem> <functional> <map> <optional> <string> <string_view> <vector>)
endfunction()

# Code that reads, checks and prints is compiled with -O1: this is most of the code, and -O1 takes 40 % less time than -O3.
function(nlo_optimise target)
  target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# nlo_add_library(NAME [HEADERS_OF LIBRARY] USES target...): adds a static library, and the object library NAME_hot for the
# sources in which a run spends its time. NAME_hot is compiled with -O3 (the others with -O1), and in Debug builds
# (sanitizers) with -O1 (the others without optimisation). HEADERS_OF: uses the precompiled headers of a library with the
# same settings.
function(nlo_add_library name)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "HEADERS_OF" "USES")
  add_library(${name}_hot OBJECT)
  add_library(${name} STATIC $<TARGET_OBJECTS:${name}_hot>)
  foreach(part IN ITEMS ${name} ${name}_hot)
    target_link_libraries(${part} PRIVATE ${arg_USES})
    target_include_directories(${part} PUBLIC ${PROJECT_SOURCE_DIR})
    if(arg_HEADERS_OF)
      string(REPLACE ${name} ${arg_HEADERS_OF} other ${part})
      target_precompile_headers(${part} REUSE_FROM ${other})
    else()
      nlo_precompile_common_headers(${part})
    endif()
  endforeach()
  nlo_optimise(${name})
  target_compile_options(${name}_hot PRIVATE "$<$<CONFIG:Release>:-O3>" "$<$<CONFIG:Debug>:-O1>")
  if(NLO_FUZZ) # libFuzzer needs counted edges. Comparisons are not traced, because this would slow all tests
    foreach(part IN ITEMS ${name} ${name}_hot)
      target_compile_options(${part} PRIVATE -fsanitize-coverage=inline-8bit-counters,pc-table)
    endforeach()
  endif()
endfunction()

# nlo_hot_sources(TARGET SOURCES...): adds sources of this folder to TARGET_hot.
function(nlo_hot_sources target)
  list(TRANSFORM ARGN PREPEND ${CMAKE_CURRENT_SOURCE_DIR}/ OUTPUT_VARIABLE sources)
  target_sources(${target}_hot PRIVATE ${sources})
endfunction()

# nlo_join_sources(TARGET FOLDERS folder... [EXCEPT folder/source.cpp...]): compiles the sources of a folder, or of
# folder+folder, as one source, because a short source spends most of its time in templates that its neighbours instantiate,
# too. EXCEPT lists sources that are compiled alone: loops of training, because GCC inlines less in a long compilation, and
# sources whose unnamed namespace has a name of a neighbour.
option(NLO_JOIN_SOURCES "Compile short sources of a folder together (./test.sh --full: each by itself)" ON)
function(nlo_join_sources target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "" "FOLDERS;EXCEPT")
  foreach(name IN LISTS arg_EXCEPT)
    if(NOT EXISTS ${CMAKE_CURRENT_SOURCE_DIR}/${name})
      message(FATAL_ERROR "nlo_join_sources(${target}): there is no ${name} to leave out; take it from EXCEPT")
    endif()
  endforeach()
  set_target_properties(${target} PROPERTIES UNITY_BUILD ${NLO_JOIN_SOURCES} UNITY_BUILD_MODE GROUP)
  get_target_property(sources ${target} SOURCES)
  foreach(source IN LISTS sources)
    cmake_path(ABSOLUTE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} NORMALIZE)
    cmake_path(RELATIVE_PATH source BASE_DIRECTORY ${CMAKE_CURRENT_SOURCE_DIR} OUTPUT_VARIABLE name)
    cmake_path(GET name PARENT_PATH folder)
    if(folder STREQUAL "")
      set(folder .)
    endif()
    foreach(folders IN LISTS arg_FOLDERS)
      string(REPLACE + ";" together "${folders}")
      if(folder IN_LIST together AND NOT name IN_LIST arg_EXCEPT)
        string(MAKE_C_IDENTIFIER "${folders}" group)
        set_property(SOURCE ${source} TARGET_DIRECTORY ${target} PROPERTY UNITY_GROUP ${group})
      endif()
    endforeach()
  endforeach()
endfunction()
