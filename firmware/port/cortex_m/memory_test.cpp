// SPDX-License-Identifier: Apache-2.0
#include "port/cortex_m/memory_test.hpp"

#include "base/memory_march.hpp"

extern "C" {
extern std::uint32_t __stack_bottom, __data_begin, __bss_end;  // sections.ld
}

namespace voltlap::port {
namespace {

constexpr std::size_t kOwnStackWords = 256;  // of this function and what it calls, with the block put aside

std::size_t words_between(const std::uint32_t* from, const std::uint32_t* to) {
  return (reinterpret_cast<std::uintptr_t>(to) - reinterpret_cast<std::uintptr_t>(from)) / sizeof *from;
}

}  // namespace

// BMS-090
bool memory_is_good() {
  std::uint32_t* top = nullptr;
  asm volatile("mov %0, sp" : "=r"(top));
  MemoryWords stack(&__stack_bottom), data(&__data_begin);
  const std::size_t unused = words_between(&__stack_bottom, top);
  const bool stack_good = march_keeping(stack, unused > kOwnStackWords ? unused - kOwnStackWords : 0);
  return march_keeping(data, words_between(&__data_begin, &__bss_end)) && stack_good;
}

}  // namespace voltlap::port
