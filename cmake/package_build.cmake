# CPack runs this file before it installs: it builds the contents of the packages for any processor of the architecture.
find_program(shlibdeps dpkg-shlibdeps)
find_program(file file)
if(NOT shlibdeps OR NOT file)
  message(FATAL_ERROR "a Debian package states the libraries that it needs, and these programs find them: install dpkg-dev and file")
endif()
message("nlo: building for any processor of this architecture in ${CPACK_NLO_BUILD} (training takes longer than by -march=native)")
set(ENV{CMAKE_PREFIX_PATH} "${CPACK_NLO_PREFIX_PATH}:$ENV{CMAKE_PREFIX_PATH}")
execute_process(COMMAND ${CMAKE_COMMAND} ${CPACK_NLO_SETTINGS} -S ${CPACK_NLO_SOURCE} -B ${CPACK_NLO_BUILD}
  OUTPUT_QUIET COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND ${CMAKE_COMMAND} --build ${CPACK_NLO_BUILD} COMMAND_ERROR_IS_FATAL ANY)
