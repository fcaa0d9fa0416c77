# SPDX-License-Identifier: Apache-2.0
# voltlap_image(<name> BOARD <board> NODES bms|master... SOURCES <file>... LIBS <target>...): an image for a board of
# firmware/port/, in images/ of the build folder: <name>.elf, .map, .bin, .hex, and <name>.spdx.json, what it is made of.
# What must not be in an image fails the build (check_image.py).
set(VOLTLAP_STACK_SIZE 4096 CACHE STRING "Stack of an image [byte]")

function(voltlap_image_info name nodes)
  set(has_bms false)
  set(has_master false)
  if(bms IN_LIST nodes)
    set(has_bms true)
  endif()
  if(master IN_LIST nodes)
    set(has_master true)
  endif()
  string(LENGTH ${name} length)
  if(length GREATER 23)
    message(FATAL_ERROR "voltlap_image(${name}): a name of at most 23 characters is expected")
  endif()
  configure_file(${PROJECT_SOURCE_DIR}/toolchain/image_info.cpp.in ${CMAKE_CURRENT_BINARY_DIR}/${name}_info.cpp @ONLY)
endfunction()

function(voltlap_image name)
  cmake_parse_arguments(PARSE_ARGV 1 IMAGE "" "BOARD" "SOURCES;LIBS;NODES")
  voltlap_image_info(${name} "${IMAGE_NODES}")
  set(folder ${CMAKE_BINARY_DIR}/images)
  add_executable(${name} ${IMAGE_SOURCES} ${CMAKE_CURRENT_BINARY_DIR}/${name}_info.cpp)
  target_link_libraries(${name} PRIVATE ${IMAGE_LIBS} voltlap_port_${IMAGE_BOARD} voltlap_port_cortex_m
                                        voltlap_config_layout)
  target_compile_options(${name} PRIVATE -fno-exceptions -fno-rtti -fno-threadsafe-statics)
  set(scripts ${PROJECT_SOURCE_DIR}/firmware/port/${IMAGE_BOARD}/memory.ld
              ${PROJECT_SOURCE_DIR}/firmware/port/cortex_m/sections.ld)
  list(TRANSFORM scripts PREPEND "-T" OUTPUT_VARIABLE script_flags)
  target_link_options(${name} PRIVATE ${script_flags} -Wl,--gc-sections -Wl,--fatal-warnings -Wl,--no-warn-rwx-segments
                                      -Wl,-Map=${folder}/${name}.map
                                      -Wl,--defsym=__stack_size=${VOLTLAP_STACK_SIZE} -Wl,--print-memory-usage)
  set_target_properties(${name} PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF SUFFIX .elf
                                           RUNTIME_OUTPUT_DIRECTORY ${folder} LINK_DEPENDS "${scripts}")
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${name}> ${folder}/${name}.bin
    COMMAND ${CMAKE_OBJCOPY} -O ihex $<TARGET_FILE:${name}> ${folder}/${name}.hex
    VERBATIM)
endfunction()
