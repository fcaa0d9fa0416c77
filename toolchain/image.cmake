# SPDX-License-Identifier: Apache-2.0
# voltlap_image(<name> BOARD <board> [PORT <port>] NODES bms|master... SOURCES <file>... LIBS <target>...
#               [CONFIGURED_BY_PLANT]): an image for a board of
# firmware/port/, in images/ of the build folder: <name>.elf, .map, .bin, .hex, <name>.stack, the deepest way of its
# calls, and <name>.spdx.json, what it is made of. What must not be in an image fails the build (check_image.py), and so
# does a stack that may not suffice (stack_use.py). Behind the image lies the CRC by which it checks itself at the start
# (image_crc.py).
set(VOLTLAP_STACK_SIZE 4096 CACHE STRING "Stack of an image [byte]")

# The checks need nothing beside Python itself.
find_program(VOLTLAP_IMAGE_PYTHON python3)
if(CMAKE_CROSSCOMPILING AND NOT VOLTLAP_IMAGE_PYTHON)
  message(FATAL_ERROR "No python3 was found, which checks the images. Install it, or name one with -DVOLTLAP_IMAGE_PYTHON=FILE.")
endif()

# What it says of itself. An image that no plant configures has pack_config.hpp, master_config.hpp or both in it.
function(voltlap_image_info name nodes by_plant)
  set(has_bms false)
  set(has_master false)
  set(includes "")
  set(bms_number 0)
  set(master_number 0)
  set(cells_in_series 0)
  set(car "\"\"")
  if(master IN_LIST nodes AND NOT by_plant)
    string(APPEND includes "#include \"master_config.hpp\"\n")
    set(master_number master::kMasterNumber)
    set(car master::kMasterCar)
  endif()
  if(bms IN_LIST nodes AND NOT by_plant)
    string(APPEND includes "#include \"pack_config.hpp\"\n")
    set(bms_number bms::kPackNumber)
    set(cells_in_series bms::kPackConfig.cells_in_series)
    set(car bms::kPackCar)
  endif()
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
  cmake_parse_arguments(PARSE_ARGV 1 IMAGE "CONFIGURED_BY_PLANT" "BOARD;PORT" "SOURCES;LIBS;NODES")
  voltlap_image_info(${name} "${IMAGE_NODES}" ${IMAGE_CONFIGURED_BY_PLANT})
  if(NOT IMAGE_PORT)
    set(IMAGE_PORT ${IMAGE_BOARD})
  endif()
  set(folder ${CMAKE_BINARY_DIR}/images)
  add_executable(${name} ${IMAGE_SOURCES} ${CMAKE_CURRENT_BINARY_DIR}/${name}_info.cpp)
  target_link_libraries(${name} PRIVATE ${IMAGE_LIBS} voltlap_port_${IMAGE_PORT} voltlap_port_cortex_m
                                        voltlap_source_numbers)
  target_compile_options(${name} PRIVATE -fno-exceptions -fno-rtti -fno-threadsafe-statics)
  set(scripts ${PROJECT_SOURCE_DIR}/firmware/port/${IMAGE_BOARD}/memory.ld
              ${PROJECT_SOURCE_DIR}/firmware/port/cortex_m/sections.ld)
  list(TRANSFORM scripts PREPEND "-T" OUTPUT_VARIABLE script_flags)
  target_link_options(${name} PRIVATE -nostdlib ${script_flags} -Wl,--gc-sections -Wl,--fatal-warnings -Wl,--no-warn-rwx-segments
                                      -Wl,-Map=${folder}/${name}.map
                                      -Wl,--defsym=__stack_size=${VOLTLAP_STACK_SIZE})
  set_target_properties(${name} PROPERTIES CXX_STANDARD 17 CXX_STANDARD_REQUIRED ON CXX_EXTENSIONS OFF SUFFIX .elf
                                           RUNTIME_OUTPUT_DIRECTORY ${folder} LINK_DEPENDS "${scripts}")
  string(TOUPPER "${CMAKE_BUILD_TYPE}" build_type)
  set(flags "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${build_type}}")
  add_custom_command(TARGET ${name} POST_BUILD
    COMMAND ${VOLTLAP_IMAGE_PYTHON} ${PROJECT_SOURCE_DIR}/toolchain/image_crc.py $<TARGET_FILE:${name}>
    COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:${name}> ${folder}/${name}.bin
    COMMAND ${CMAKE_OBJCOPY} -O ihex --gap-fill 0 $<TARGET_FILE:${name}> ${folder}/${name}.hex
    COMMAND ${VOLTLAP_IMAGE_PYTHON} ${PROJECT_SOURCE_DIR}/toolchain/check_image.py --map ${folder}/${name}.map
            $<TARGET_FILE:${name}>
    COMMAND ${VOLTLAP_IMAGE_PYTHON} ${PROJECT_SOURCE_DIR}/toolchain/stack_use.py --limit ${VOLTLAP_STACK_SIZE}
            $<TARGET_FILE:${name}> > ${folder}/${name}.stack
    COMMAND ${VOLTLAP_IMAGE_PYTHON} ${PROJECT_SOURCE_DIR}/toolchain/image_sbom.py --version ${PROJECT_VERSION}
            --compiler ${CMAKE_CXX_COMPILER} --flags=${flags} --root ${PROJECT_SOURCE_DIR} --build ${CMAKE_BINARY_DIR}
            $<TARGET_FILE:${name}>
    VERBATIM)
endfunction()
