# What a user gets from `cmake --install`: the runtime's headers, the program with its man page and completion, the
# experiments to start from, and find_package(nlo). The trainer's libraries stay inside: their interface is the program.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/nlo)

# nlo_install_component(NAME TARGET): a component of find_package(nlo), in a file that the package reads.
function(nlo_install_component name target)
  install(TARGETS ${target} EXPORT nlo_${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  install(EXPORT nlo_${name} NAMESPACE nlo:: DESTINATION ${package_dir})
endfunction()

nlo_install_component(runtime nlo_runtime)
install(DIRECTORY runtime/include/nlo DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.inc")
if(NOT NLO_RUNTIME_ONLY)
  nlo_install_component(program nlo)
  install(DIRECTORY trainer/experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/nlo FILES_MATCHING PATTERN "*.toml")
  install(FILES ${PROJECT_BINARY_DIR}/trainer/nlo.bash
    DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME nlo)
  install(FILES ${PROJECT_BINARY_DIR}/trainer/nlo.zsh DESTINATION ${CMAKE_INSTALL_DATADIR}/zsh/site-functions RENAME _nlo)
  install(FILES ${PROJECT_BINARY_DIR}/trainer/nlo.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
  install(FILES codegen/cmake/NloAddModel.cmake DESTINATION ${package_dir})
endif()

configure_package_config_file(cmake/nloConfig.cmake.in nloConfig.cmake INSTALL_DESTINATION ${package_dir})
# Headers, and a program that runs on the host: neither depends on the processor that a user compiles for.
write_basic_package_version_file(nloConfigVersion.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nloConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/nloConfigVersion.cmake
  DESTINATION ${package_dir})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
