# SPDX-License-Identifier: Apache-2.0
# cmake -DOUT=FILE -P source_numbers.cmake HEADER... -- SOURCE...: two numbers as a C++ header, made from texts without
# comments and blanks: of the headers that lay out a node's configuration, and of these and all that makes the nodes.
# Two builds with equal numbers lay it out alike, and send the same frames.
set(text "")
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(k RANGE 0 ${last})
  set(argument "${CMAKE_ARGV${k}}")
  if(argument STREQUAL "--")
    string(SHA256 layout "${text}")
  elseif(argument MATCHES "^[^-].*\\.([hc]pp|dbc)$")
    file(READ "${argument}" source)
    string(REGEX REPLACE "//[^\n]*" "" source "${source}")
    string(REGEX REPLACE "[ \t\r\n]+" " " source "${source}")
    string(APPEND text "${source}")
  endif()
endforeach()
if(NOT DEFINED layout)
  message(FATAL_ERROR "source_numbers.cmake: no -- was given, which stands between headers and sources")
endif()
string(SHA256 sources "${text}")
string(SUBSTRING ${layout} 0 8 layout)
string(SUBSTRING ${sources} 0 8 sources)
set(header "// SPDX-License-Identifier: Apache-2.0
// Made at build time by toolchain/source_numbers.cmake.
#pragma once
#include <cstdint>

namespace voltlap::port {

/// Of bms::Config and master::Config: equal numbers, equal bytes.
inline constexpr std::uint32_t kConfigLayout = 0x${layout}U;
/// Of the nodes and their messages: equal numbers, equal frames.
inline constexpr std::uint32_t kNodeSources = 0x${sources}U;

}  // namespace voltlap::port
")
file(WRITE "${OUT}.new" "${header}")
file(COPY_FILE "${OUT}.new" "${OUT}" ONLY_IF_DIFFERENT)
