// SPDX-License-Identifier: Apache-2.0
// What stands around a board that is driven in lockstep: a stream of bytes to the plant and back, and, where the board
// is emulated, instruments. An emulator's semihosting, a process's pipe and a serial line each have their own.
#pragma once
#include <cstddef>
#include <cstdint>

namespace voltlap::port {

class Rig {
 public:
  /// Waits for at least one byte and takes those that are there, at most `capacity`; 0 when the other side has closed.
  virtual std::size_t read(std::uint8_t* bytes, std::size_t capacity) = 0;
  /// All of them, in their order; false when the other side has closed.
  virtual bool write(const std::uint8_t* bytes, std::size_t count) = 0;
  /// False where nobody counts the processor's instructions.
  [[nodiscard]] virtual bool counts() const = 0;
  /// Counts up with them, in steps of some tens, and wraps.
  [[nodiscard]] virtual std::uint32_t instructions() const = 0;
  /// Deepest use of the stack so far, and how much there is [byte]; 0 where it is not known.
  [[nodiscard]] virtual std::uint32_t stack_used() const = 0;
  [[nodiscard]] virtual std::uint32_t stack_size() const = 0;
  /// The processor is reset: the image begins anew, and of its memory only what outlives the supply is kept.
  [[noreturn]] virtual void restart() = 0;
  /// The run is over, or cannot go on: never returns.
  [[noreturn]] virtual void end(bool good) = 0;

 protected:
  ~Rig() = default;
};

}  // namespace voltlap::port
