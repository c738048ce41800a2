# nlo_firmware(TARGET): makes an executable an image for the board that the toolchain file names in NLO_BOARD: start-up
# code, linker script, semihosting. TARGET_run (a custom target) runs it in qemu-system-arm.
set(NLO_BOARD_DIR ${CMAKE_CURRENT_LIST_DIR})
enable_language(C)
enable_language(ASM)

function(nlo_firmware target)
  if(NOT EXISTS ${NLO_BOARD_DIR}/${NLO_BOARD}.ld)
    message(FATAL_ERROR "nlo_firmware(${target}): there is no board \"${NLO_BOARD}\" in ${NLO_BOARD_DIR}; configure with "
      "--toolchain toolchains/cortex-m4f.cmake or another cortex-m*.cmake")
  endif()
  set_target_properties(${target} PROPERTIES SUFFIX .elf LINK_DEPENDS "${NLO_BOARD_DIR}/${NLO_BOARD}.ld;${NLO_BOARD_DIR}/sections.ld")
  target_sources(${target} PRIVATE ${NLO_BOARD_DIR}/startup.S ${NLO_BOARD_DIR}/semihosting.c)
  target_include_directories(${target} PRIVATE ${NLO_BOARD_DIR})
  # nano.specs: the small newlib, for the memcpy and memset that a compiler may call.
  target_link_options(${target} PRIVATE -nostartfiles --specs=nano.specs --specs=nosys.specs -L${NLO_BOARD_DIR}
    -T${NLO_BOARD}.ld -Wl,--gc-sections -Wl,--no-warn-rwx-segments -Wl,-Map=${target}.map)
  # With icount one instruction takes 1 ns of the board's time, so that every run is the same, and waiting takes none.
  add_custom_target(${target}_run
    COMMAND qemu-system-arm -M ${NLO_BOARD} -icount shift=0,sleep=off -nographic -monitor none -serial null
      -semihosting-config enable=on,target=native -kernel $<TARGET_FILE:${target}>
    DEPENDS ${target} USES_TERMINAL VERBATIM)
endfunction()
