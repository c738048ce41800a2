# Installs the runtime's headers, the program, experiments to start from, and files for find_package(nlo) and pkg-config.
# The trainer's libraries are not installed: their interface is the program. The components are runtime, program, and
# the bindings model and python. NloPackage.cmake makes a package of each.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_dir ${CMAKE_INSTALL_DATADIR}/cmake/nlo) # not lib, because headers and a program of the host do not depend on the target's processor

# nlo_install_component(NAME TARGET): installs TARGET as a component of find_package(nlo), in a file that the package reads.
function(nlo_install_component name target)
  install(TARGETS ${target} EXPORT nlo_${name} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT ${name})
  install(EXPORT nlo_${name} NAMESPACE nlo:: DESTINATION ${package_dir} COMPONENT ${name})
endfunction()

nlo_install_component(runtime nlo_runtime)
install(DIRECTORY runtime/include/nlo DESTINATION ${CMAKE_INSTALL_INCLUDEDIR} COMPONENT runtime
  FILES_MATCHING PATTERN "*.h" PATTERN "*.inc")
if(NOT NLO_RUNTIME_ONLY)
  nlo_install_component(program nlo)
  install(TARGETS nlo-prove nlo-reproduce DESTINATION ${CMAKE_INSTALL_BINDIR} COMPONENT program OPTIONAL) # installed only if they were built
  install(DIRECTORY trainer/experiments DESTINATION ${CMAKE_INSTALL_DATADIR}/nlo COMPONENT program
    FILES_MATCHING PATTERN "*.toml")
  install(FILES codegen/cmake/NloAddModel.cmake DESTINATION ${package_dir} COMPONENT program)
endif()

configure_package_config_file(cmake/nloConfig.cmake.in nloConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(nloConfigVersion.cmake COMPATIBILITY SameMinorVersion ARCH_INDEPENDENT)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nloConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/nloConfigVersion.cmake
  DESTINATION ${package_dir} COMPONENT runtime)
configure_file(cmake/nlo.pc.in nlo.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/nlo.pc DESTINATION ${CMAKE_INSTALL_DATADIR}/pkgconfig COMPONENT runtime)
install(FILES LICENSE DESTINATION ${CMAKE_INSTALL_DOCDIR} COMPONENT licence) # packages have it elsewhere

if(PROJECT_IS_TOP_LEVEL)
  include(NloPackage)
endif()
