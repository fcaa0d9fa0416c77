// SPDX-License-Identifier: Apache-2.0
// A board in lockstep behind a serial line with SLCAN: to `slcand` or python-can it is an adapter, and on the bus
// behind that a member of the lockstep, as `voltlap ecu` is. The plant's Sync steps it, its Done ends its turn.
#pragma once
#include "port/lockstep/frame_bytes.hpp"
#include "port/lockstep/rig.hpp"
#include "port/serial/serial.hpp"
#include "port/serial/slcan.hpp"

namespace voltlap::port {

class SlcanRig final : public Rig {
 public:
  /// Resets the processor: never returns.
  using Reset = void (*)();

  /// `polls_per_hello`: looks at a silent line after which the board says again that it is ready, until the first Sync.
  SlcanRig(Serial& serial, Reset reset, std::uint32_t polls_per_hello)
      : serial_(serial), reset_(reset), polls_per_hello_(polls_per_hello) {}

  std::size_t read(std::uint8_t* bytes, std::size_t capacity) override;
  /// Whole frames. Waits until the host has opened the channel.
  bool write(const std::uint8_t* bytes, std::size_t count) override;
  [[nodiscard]] bool counts() const override { return false; }
  [[nodiscard]] std::uint32_t instructions() const override { return 0; }
  [[nodiscard]] std::uint32_t stack_used() const override { return 0; }
  [[nodiscard]] std::uint32_t stack_size() const override { return 0; }
  [[noreturn]] void restart() override {
    for (;;) reset_();
  }
  /// The plant is gone; the board begins anew and waits for the next one.
  [[noreturn]] void end(bool /*good*/) override { restart(); }

 private:
  static constexpr std::size_t kHelloMax = 2 * kFrameBytes;  ///< READY of both nodes

  /// Takes a byte, if there is one, and answers it. True when it ends a frame.
  bool poll(Frame& frame, bool& idle);
  void say(const char* text);
  void send(const std::uint8_t* bytes, std::size_t count);

  Serial& serial_;
  const Reset reset_;
  Slcan slcan_;
  const std::uint32_t polls_per_hello_;
  std::uint8_t hello_[kHelloMax] = {};
  std::size_t hello_count_ = 0;  ///< [byte]
  bool greeted_ = false;         ///< the first frames are said, and are no hello any more once the plant has stepped it
  bool stepped_ = false;
};

}  // namespace voltlap::port
