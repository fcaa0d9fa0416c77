// SPDX-License-Identifier: Apache-2.0
// From reset to main() on any Cortex-M: the stack painted, .data copied, .bss cleared. A board's port defines
// `board_fault` and, where it uses interrupts, the handlers by name; those that it leaves out are faults.
#include <cstddef>
#include <cstdint>

#include "port/cortex_m/stack.hpp"

/// main(), by a name that may be called.
int image_main() asm("main");

extern "C" {

extern std::uint32_t __stack_bottom, __stack_top;                          // sections.ld
extern std::uint32_t __data_begin, __data_end, __data_in_flash, __bss_begin, __bss_end;

[[noreturn]] void reset();
/// Outputs off, and never back: an exception that nobody expects. `number`: as in IPSR, 2 NMI, 3 HardFault, from 16 on
/// the board's interrupts.
[[noreturn]] void board_fault(std::uint32_t number);

void unexpected_exception() {
  std::uint32_t number = 0;
  asm volatile("mrs %0, ipsr" : "=r"(number));
  board_fault(number);
}

void nmi_handler() __attribute__((weak, alias("unexpected_exception")));
void svc_handler() __attribute__((weak, alias("unexpected_exception")));
void pendsv_handler() __attribute__((weak, alias("unexpected_exception")));
void systick_handler() __attribute__((weak, alias("unexpected_exception")));

/// libgcc's division names it in its unwind tables, which sections.ld leaves out: nothing is ever thrown.
void __aeabi_unwind_cpp_pr0() {}

}  // extern "C"

namespace {

using Handler = void (*)();

/// ARMv6-M and ARMv7-M Architecture Reference Manuals, B1.5.3: the stack pointer, 15 exceptions, then the interrupts,
/// of which a board without them needs none.
struct Vectors {
  std::uint32_t* stack;
  Handler exception[15];
};

__attribute__((section(".vectors"), used)) const Vectors kVectors = {
    &__stack_top,
    {reset, nmi_handler, unexpected_exception, unexpected_exception, unexpected_exception, unexpected_exception,
     nullptr, nullptr, nullptr, nullptr, svc_handler, unexpected_exception, nullptr, pendsv_handler, systick_handler}};

void clear(std::uint32_t* from, const std::uint32_t* to) {
  for (; from < to; ++from) *from = 0;
}

/// All that is not in use yet: below this function's own frame.
void paint_stack() {
  std::uint32_t* top = nullptr;
  asm volatile("mov %0, sp" : "=r"(top));
  for (std::uint32_t* word = &__stack_bottom; word < top; ++word) *word = voltlap::port::kStackPaint;
}

}  // namespace

void reset() {
  paint_stack();
  const std::uint32_t* from = &__data_in_flash;
  for (std::uint32_t* to = &__data_begin; to < &__data_end; ++to) *to = *from++;
  clear(&__bss_begin, &__bss_end);
  static_cast<void>(image_main());
  board_fault(0);
}
