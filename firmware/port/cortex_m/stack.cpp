// SPDX-License-Identifier: Apache-2.0
#include "port/cortex_m/stack.hpp"

extern "C" {
extern std::uint32_t __stack_bottom, __stack_top;  // sections.ld
}

namespace voltlap::port {

std::uint32_t stack_used() {
  const std::uint32_t* lowest = &__stack_bottom;
  while (lowest < &__stack_top && *lowest == kStackPaint) ++lowest;
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&__stack_top) -
                                    reinterpret_cast<std::uintptr_t>(lowest));
}

std::uint32_t stack_size() {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(&__stack_top) -
                                    reinterpret_cast<std::uintptr_t>(&__stack_bottom));
}

}  // namespace voltlap::port
