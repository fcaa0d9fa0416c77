# SPDX-License-Identifier: Apache-2.0
# cmake -DOUT=FILE -P config_layout.cmake HEADER...: a number made from the text of the headers that lay out a node's
# configuration, without comments and blanks. Two builds with equal numbers lay it out alike.
set(text "")
math(EXPR last "${CMAKE_ARGC} - 1")
foreach(k RANGE 0 ${last})
  set(argument "${CMAKE_ARGV${k}}")
  if(argument MATCHES "^[^-].*\\.hpp$")
    file(READ "${argument}" header)
    string(REGEX REPLACE "//[^\n]*" "" header "${header}")
    string(REGEX REPLACE "[ \t\r\n]+" " " header "${header}")
    string(APPEND text "${header}")
  endif()
endforeach()
if(text STREQUAL "")
  message(FATAL_ERROR "config_layout.cmake: no header was given")
endif()
string(SHA256 digest "${text}")
string(SUBSTRING ${digest} 0 8 number)
set(header "// SPDX-License-Identifier: Apache-2.0
// Made at build time by toolchain/config_layout.cmake.
#pragma once
#include <cstdint>

namespace voltlap::port {

/// Of bms::Config and master::Config: equal numbers, equal bytes.
inline constexpr std::uint32_t kConfigLayout = 0x${number}U;

}  // namespace voltlap::port
")
file(WRITE "${OUT}.new" "${header}")
file(COPY_FILE "${OUT}.new" "${OUT}" ONLY_IF_DIFFERENT)
