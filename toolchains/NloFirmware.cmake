# nlo_firmware(TARGET): turns an executable into an image for the board that the toolchain file names in NLO_BOARD, with
# start-up code, linker script and semihosting. The custom target TARGET_run runs it in an emulator (emulate.sh).
set(NLO_EMULATE ${CMAKE_CURRENT_LIST_DIR}/emulate.sh)
set(NLO_TOOLCHAINS_DIR ${CMAKE_CURRENT_LIST_DIR})
enable_language(C)
enable_language(ASM)

function(nlo_firmware target)
  if(NOT EXISTS ${NLO_BOARD_DIR}/${NLO_BOARD}.ld)
    message(FATAL_ERROR "nlo_firmware(${target}): there is no board \"${NLO_BOARD}\" in \"${NLO_BOARD_DIR}\"; configure with "
      "--toolchain toolchains/cortex-m4f.cmake or another cortex-m*.cmake")
  endif()
  file(GLOB scripts ${NLO_BOARD_DIR}/*.ld)
  file(GLOB sources ${NLO_BOARD_DIR}/*.S ${NLO_BOARD_DIR}/*.c)
  set_target_properties(${target} PROPERTIES SUFFIX .elf LINK_DEPENDS "${scripts}")
  target_sources(${target} PRIVATE ${sources})
  target_include_directories(${target} PRIVATE ${NLO_TOOLCHAINS_DIR})
  target_link_options(${target} PRIVATE ${NLO_BOARD_LINK_OPTIONS} -L${NLO_BOARD_DIR} -T${NLO_BOARD}.ld -Wl,--gc-sections
    -Wl,--no-warn-rwx-segments -Wl,-Map=${target}.map)
  # With icount one instruction takes 1 ns of the board's time, so every run is the same, and waiting takes no real time.
  add_custom_target(${target}_run
    COMMAND ${NLO_EMULATE} ${NLO_BOARD} $<TARGET_FILE:${target}> -icount shift=0,sleep=off
    DEPENDS ${target} USES_TERMINAL VERBATIM)
endfunction()
