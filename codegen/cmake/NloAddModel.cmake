# nlo_add_model(TARGET MODEL file.json [NAME identifier] [SCALAR float|double|int16]
#   [WEIGHTS float|bf16|fp16] [MAX_ERROR limit])
#
# Generates NAME.h from a model file at build time, and again whenever the file (or the program `nlo`) changes.
#   TARGET  an existing executable or library, whose sources may include "NAME.h". Any other name becomes an
#           INTERFACE library to link, for a model that several targets share.
#   NAME    the observer is nlo::NAME::Observer; default: the file's name without its ending
#   SCALAR  default: float
#   WEIGHTS, MAX_ERROR  as --weights and --max-error of nlo export; with a larger error the build fails
function(nlo_add_model target)
  cmake_parse_arguments(PARSE_ARGV 1 arg "" "MODEL;NAME;SCALAR;WEIGHTS;MAX_ERROR" "")
  if(arg_UNPARSED_ARGUMENTS OR NOT arg_MODEL)
    message(FATAL_ERROR "nlo_add_model(${target}): wants MODEL file.json, does not know \"${arg_UNPARSED_ARGUMENTS}\"")
  endif()
  cmake_path(ABSOLUTE_PATH arg_MODEL NORMALIZE OUTPUT_VARIABLE model)
  if(NOT EXISTS ${model})
    message(FATAL_ERROR "nlo_add_model(${target}): there is no ${model}")
  endif()
  if(NOT arg_NAME)
    cmake_path(GET model STEM LAST_ONLY arg_NAME)
  endif()
  if(NOT arg_SCALAR)
    set(arg_SCALAR float)
  endif()
  set(options --scalar ${arg_SCALAR})
  if(arg_WEIGHTS)
    list(APPEND options --weights ${arg_WEIGHTS})
  endif()
  if(arg_MAX_ERROR)
    list(APPEND options --max-error ${arg_MAX_ERROR})
  endif()

  set(program nlo) # inside nlo's own tree
  if(NLO_PROGRAM) # a cross build: the program of the host
    set(program ${NLO_PROGRAM})
  elseif(TARGET nlo::nlo)
    set(program nlo::nlo)
  endif()
  set(folder ${CMAKE_CURRENT_BINARY_DIR}/nlo_models/${target})
  set(header ${folder}/${arg_NAME}.h)
  file(MAKE_DIRECTORY ${folder})
  add_custom_command(OUTPUT ${header}
    COMMAND ${program} export ${model} --quiet --target cpp ${options} --name ${arg_NAME} -o ${header}
    DEPENDS ${model} ${program}
    COMMENT "Exporting ${arg_NAME}.h"
    VERBATIM)
  add_custom_target(${target}_${arg_NAME}_header DEPENDS ${header})

  if(TARGET ${target})
    set(visibility PUBLIC)
    get_target_property(type ${target} TYPE)
    if(type STREQUAL EXECUTABLE)
      set(visibility PRIVATE)
    elseif(type STREQUAL INTERFACE_LIBRARY)
      set(visibility INTERFACE)
    endif()
  else()
    add_library(${target} INTERFACE)
    set(visibility INTERFACE)
  endif()
  add_dependencies(${target} ${target}_${arg_NAME}_header)
  target_include_directories(${target} ${visibility} $<BUILD_INTERFACE:${folder}>)
  target_link_libraries(${target} ${visibility} nlo::runtime)
endfunction()
