# CPack runs this file before it packs the installed folder of each component: it adds the documents that Debian requires.
# help2man makes the manual pages from --help and --version of the programs.
find_program(help2man help2man)
if(NOT help2man)
  message(FATAL_ERROR "a Debian package has a manual page for each program: install help2man")
endif()
file(STRINGS ${CPACK_NLO_SOURCE}/CHANGELOG.md release REGEX "^## \\[${CPACK_PACKAGE_VERSION}\\]")
string(REGEX REPLACE ".* - " "" day "${release}")
execute_process(COMMAND env LC_ALL=C date -u -R -d "${day}" OUTPUT_VARIABLE date COMMAND_ERROR_IS_FATAL ANY)
execute_process(COMMAND date -u -d "${day}" +%s OUTPUT_VARIABLE epoch OUTPUT_STRIP_TRAILING_WHITESPACE COMMAND_ERROR_IS_FATAL ANY)
foreach(component IN LISTS CPACK_COMPONENTS_ALL)
  string(TOUPPER ${component} upper)
  set(share ${CPACK_TEMPORARY_DIRECTORY}/${component}/usr/share)
  set(documents ${share}/doc/${CPACK_DEBIAN_${upper}_PACKAGE_NAME})
  file(MAKE_DIRECTORY ${documents})
  configure_file(${CPACK_NLO_SOURCE}/LICENSE ${documents}/copyright COPYONLY)
  configure_file(${CPACK_NLO_SOURCE}/CHANGELOG.md ${documents}/CHANGELOG.md COPYONLY)
  file(WRITE ${documents}/changelog "nlo (${CPACK_PACKAGE_VERSION}) unstable; urgency=medium

  * See CHANGELOG.md.gz in this folder.

 -- ${CPACK_PACKAGE_CONTACT}  ${date}")
  file(GLOB programs ${share}/../bin/*)
  foreach(program IN LISTS programs)
    get_filename_component(name ${program} NAME)
    file(MAKE_DIRECTORY ${share}/man/man1)
    execute_process(COMMAND env "SOURCE_DATE_EPOCH=${epoch}" COLUMNS=80 ${help2man} --no-info
      "--name=learned state observers for control loops" --output=${share}/man/man1/${name}.1 ${program}
      COMMAND_ERROR_IS_FATAL ANY)
  endforeach()
  file(GLOB pages ${share}/man/man*/*)
  execute_process(COMMAND gzip -9nf ${documents}/changelog ${documents}/CHANGELOG.md ${pages} COMMAND_ERROR_IS_FATAL ANY)
  file(CHMOD_RECURSE ${share}/doc FILE_PERMISSIONS OWNER_READ OWNER_WRITE GROUP_READ WORLD_READ
    DIRECTORY_PERMISSIONS ${CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS}) # whatever the umask was
endforeach()
