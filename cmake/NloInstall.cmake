# What a user gets from `cmake --install`: the runtime's headers, the program with its man page and completion, the
# experiments to start from, and find_package(nlo). The trainer's libraries stay inside: their interface is the program.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/nlo)

install(TARGETS nlo_runtime nlo EXPORT nloTargets RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
install(DIRECTORY runtime/include/nlo DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} FILES_MATCHING PATTERN "*.h" PATTERN "*.inc")
install(DIRECTORY trainer/experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/nlo FILES_MATCHING PATTERN "*.toml")
install(FILES ${PROJECT_BINARY_DIR}/trainer/nlo.bash
  DESTINATION ${CMAKE_INSTALL_DATADIR}/bash-completion/completions RENAME nlo)
install(FILES ${PROJECT_BINARY_DIR}/trainer/nlo.1 DESTINATION ${CMAKE_INSTALL_MANDIR}/man1)
install(EXPORT nloTargets NAMESPACE nlo:: DESTINATION ${package_dir})

configure_package_config_file(cmake/nloConfig.cmake.in nloConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(nloConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/nloConfig.cmake ${PROJECT_BINARY_DIR}/nloConfigVersion.cmake
  codegen/cmake/NloAddModel.cmake DESTINATION ${package_dir})
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR})
