// SPDX-License-Identifier: Apache-2.0
// What an emulated board says of a defect before it ends: onto the emulator's standard error, by semihosting.
#include "base/require.hpp"
#include "port/mps2_an386/semihosting.hpp"

extern "C" [[noreturn]] void board_fault(std::uint32_t number);

namespace {

constexpr std::uint32_t kExitDefect = 70;

}  // namespace

namespace voltlap {

void require_failed(const char* condition, const char* file, int /*line*/) {
  port::semihosting::write_text("voltlap image: defect: this does not hold: ");
  port::semihosting::write_text(condition);
  port::semihosting::write_text(" in ");
  port::semihosting::write_text(file);
  port::semihosting::write_text("\n");
  port::semihosting::exit(kExitDefect);
}

}  // namespace voltlap

extern "C" void board_fault(std::uint32_t number) {
  char text[] = "voltlap image: exception 00 of the processor (3: HardFault), which nobody expects\n";
  constexpr std::size_t kDigits = 25;
  text[kDigits] = static_cast<char>('0' + number / 10 % 10);
  text[kDigits + 1] = static_cast<char>('0' + number % 10);
  voltlap::port::semihosting::write_text(text);
  voltlap::port::semihosting::exit(kExitDefect);
}
