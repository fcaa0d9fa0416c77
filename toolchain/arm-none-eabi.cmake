# SPDX-License-Identifier: Apache-2.0
# ARM Cortex-M without an operating system: VOLTLAP_CPU says which (cortex-m0plus, cortex-m4, cortex-m7; the presets set
# it). A floating-point unit stays unused: with the soft-float ABI a stray float turns into a helper call, and
# check_firmware_objects.py refuses it.
set(VOLTLAP_CPU cortex-m4 CACHE STRING "Processor as GCC's -mcpu names it")
set_property(CACHE VOLTLAP_CPU PROPERTY STRINGS cortex-m0plus cortex-m4 cortex-m7)
# CMake tries the compiler in a project of its own, which must know it too.
list(APPEND CMAKE_TRY_COMPILE_PLATFORM_VARIABLES VOLTLAP_CPU)
if(NOT VOLTLAP_CPU MATCHES "^cortex-m(0plus|4|7)$")
  message(FATAL_ERROR "VOLTLAP_CPU=${VOLTLAP_CPU}: cortex-m0plus, cortex-m4 or cortex-m7 is expected.")
endif()
set(CMAKE_SYSTEM_NAME Generic)
set(CMAKE_SYSTEM_PROCESSOR ${VOLTLAP_CPU})

set(CMAKE_C_COMPILER arm-none-eabi-gcc)
set(CMAKE_CXX_COMPILER arm-none-eabi-g++)
set(CMAKE_ASM_COMPILER arm-none-eabi-gcc)
set(CMAKE_TRY_COMPILE_TARGET_TYPE STATIC_LIBRARY)

set(cpu_flags "-mcpu=${VOLTLAP_CPU} -mthumb -mfloat-abi=soft")
set(language_flags "-ffreestanding -ffunction-sections -fdata-sections -fno-unwind-tables -fno-asynchronous-unwind-tables")
set(CMAKE_C_FLAGS_INIT "${cpu_flags} ${language_flags}")
set(CMAKE_CXX_FLAGS_INIT "${cpu_flags} ${language_flags} -fno-exceptions -fno-rtti -fno-use-cxa-atexit")
# What an image has besides its own code is libgcc: division of 64 bits, and the multiplications and jumps of an M0+.
set(CMAKE_EXE_LINKER_FLAGS_INIT "${cpu_flags}")
set(CMAKE_C_STANDARD_LIBRARIES -lgcc)
set(CMAKE_CXX_STANDARD_LIBRARIES -lgcc)

set(CMAKE_FIND_ROOT_PATH_MODE_PROGRAM NEVER)
set(CMAKE_FIND_ROOT_PATH_MODE_LIBRARY ONLY)
set(CMAKE_FIND_ROOT_PATH_MODE_INCLUDE ONLY)
