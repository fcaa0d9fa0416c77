// SPDX-License-Identifier: Apache-2.0
// What a debugger or an emulator does for an image that asks it: "Semihosting for AArch32 and AArch64", Arm, 2.0.
// Only for boards that are emulated: without a debugger the instruction is a fault.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port::semihosting {

enum class Operation : std::uint32_t {
  kOpen = 0x01,
  kWriteText = 0x04,
  kWrite = 0x05,
  kRead = 0x06,
  kCommandLine = 0x15,
  kExitExtended = 0x20,
};

/// BKPT 0xAB with the operation in r0 and its argument in r1; the answer comes back in r0 (section 3 of the document).
inline std::uint32_t call(Operation operation, const void* argument) {
  register std::uint32_t r0 asm("r0") = static_cast<std::uint32_t>(operation);
  register const void* r1 asm("r1") = argument;
  asm volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
  return r0;
}

inline std::uint32_t word_of(const void* address) {
  return static_cast<std::uint32_t>(reinterpret_cast<std::uintptr_t>(address));
}

/// Onto the emulator's standard error.
inline void write_text(const char* text) { static_cast<void>(call(Operation::kWriteText, text)); }

/// `length` without the final zero; mode 1 "rb", 5 "wb" (section 4.5). All ones: it cannot be opened.
inline std::uint32_t open(const char* path, std::uint32_t length, std::uint32_t mode) {
  const std::uint32_t block[] = {word_of(path), mode, length};
  return call(Operation::kOpen, block);
}

/// How many bytes were not read: all of them at the end of the file.
inline std::uint32_t read(std::uint32_t file, std::uint8_t* bytes, std::uint32_t count) {
  const std::uint32_t block[] = {file, word_of(bytes), count};
  return call(Operation::kRead, block);
}

/// How many bytes were not written.
inline std::uint32_t write(std::uint32_t file, const std::uint8_t* bytes, std::uint32_t count) {
  const std::uint32_t block[] = {file, word_of(bytes), count};
  return call(Operation::kWrite, block);
}

/// The words that the emulator was started with; false when they do not fit.
inline bool command_line(char* text, std::uint32_t capacity) {
  const std::uint32_t block[] = {word_of(text), capacity};
  return call(Operation::kCommandLine, block) == 0;
}

[[noreturn]] inline void exit(std::uint32_t code) {
  constexpr std::uint32_t kApplicationExit = 0x20026;  // ADP_Stopped_ApplicationExit
  const std::uint32_t block[] = {kApplicationExit, code};
  for (;;) static_cast<void>(call(Operation::kExitExtended, block));
}

}  // namespace voltlap::port::semihosting
