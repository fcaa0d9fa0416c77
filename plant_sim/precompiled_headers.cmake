# SPDX-License-Identifier: Apache-2.0
# Headers that are read once for all files (VOLTLAP_PCH). Every file still includes what it uses: it must build without
# them, which tests/toolchain/headers_test.py shows for a part of the files, and every build with ccache for all.
#
#   voltlap_read_ahead(<target>... [EIGEN])   standard library and fmt; with EIGEN that, too
# GCC takes headers that were read at another level of optimization, and then optimizes as they were: who asks for -O3
# has headers of its own.
function(voltlap_read_ahead)
  cmake_parse_arguments(PARSE_ARGV 0 READ "EIGEN" "" "")
  if(NOT VOLTLAP_PCH)
    return()
  endif()
  foreach(target IN LISTS READ_UNPARSED_ARGUMENTS)
    if(NOT TARGET ${target})
      continue()
    endif()
    set(headers voltlap_headers)
    if(READ_EIGEN)
      string(APPEND headers _eigen)
    endif()
    get_target_property(options ${target} COMPILE_OPTIONS)
    if("-O3" IN_LIST options)
      string(APPEND headers _o3)
    endif()
    target_precompile_headers(${target} REUSE_FROM ${headers})
  endforeach()
endfunction()

if(NOT VOLTLAP_PCH)
  return()
endif()
# Their holders may have no definition that a reader lacks, so they are targets of their own.
file(CONFIGURE OUTPUT ${CMAKE_CURRENT_BINARY_DIR}/headers.cpp CONTENT "// Only there for its headers.\n")
foreach(level IN ITEMS "" _o3)
  foreach(eigen IN ITEMS "" _eigen)
    if(eigen AND NOT VOLTLAP_LEARN)
      continue()
    endif()
    set(holder voltlap_headers${eigen}${level})
    add_library(${holder} OBJECT EXCLUDE_FROM_ALL ${CMAKE_CURRENT_BINARY_DIR}/headers.cpp)
    target_link_libraries(${holder} PRIVATE fmt::fmt tomlplusplus::tomlplusplus)
    target_precompile_headers(${holder} PRIVATE
      <algorithm> <array> <cmath> <cstdint> <filesystem> <functional> <limits> <map> <memory> <optional> <random> <span>
      <string> <string_view> <vector> <fmt/format.h> <fmt/ranges.h>)
    if(level)
      target_compile_options(${holder} PRIVATE -O3)
    endif()
    if(eigen)
      find_package(Eigen3 REQUIRED)
      target_link_libraries(${holder} PRIVATE Eigen3::Eigen)
      target_precompile_headers(${holder} PRIVATE <Eigen/Dense>)
    endif()
  endforeach()
endforeach()
voltlap_read_ahead(voltlap_core voltlap_files voltlap_page voltlap_bus voltlap_socket_bus voltlap_python_module
                   voltlap_logs voltlap_log_plot voltlap_car voltlap_race voltlap_course_import voltlap_race_report
                   voltlap_bench voltlap_firmware_loop)
voltlap_read_ahead(EIGEN voltlap_identify voltlap_validate voltlap_causes voltlap_explanation)
