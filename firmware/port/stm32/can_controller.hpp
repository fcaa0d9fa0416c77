// SPDX-License-Identifier: Apache-2.0
// What the drivers of both controllers, bxCAN and FDCAN, share: errors, counts, and the rings between a node's tick and
// the interrupts.
//
// Why interrupts: both controllers hold three received frames. At 500 kbit/s three frames of 8 bytes take 0.67 ms and
// a tick 10 ms, so polling once a tick would lose most of them, and polling in between would have to be spread over
// all of the node's step. An interrupt takes at most kFramesPerInterrupt frames; its time is bounded by the bus
// itself, which brings one frame in 94 us at best (0 bytes, 47 bits).
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "port/can.hpp"

namespace voltlap::port::stm32 {

enum class CanError : std::uint8_t {
  kNone = 0,
  kBitTiming = 1,  ///< the clock cannot make this bit rate, see can_timing.hpp
  kFilters = 2,    ///< more identifiers than the controller's filters hold
  kNoInit = 3,     ///< it does not acknowledge initialisation: clock off, or no such peripheral
  kNotOnBus = 4,   ///< it waits for 11 recessive bits: a short, or no transceiver. It goes on by itself when they come.
};

struct CanCounts {
  std::uint32_t received = 0;
  std::uint32_t sent = 0;       ///< that were put into a mailbox
  std::uint32_t overruns = 0;   ///< times that the controller lost frames: the interrupt came too late
  std::uint32_t inbox_full = 0; ///< frames lost: the node did not take them
  std::uint32_t dropped = 0;    ///< frames not sent: older than a step, or the bus was off
  std::uint32_t bus_off = 0;
  std::uint32_t recovered = 0;  ///< from it
};

/// Frames between one writer and one reader, one of which may interrupt the other. Indices only ever grow.
template <std::size_t N>
class FrameRing {
  static_assert((N & (N - 1)) == 0, "the indices wrap");

 public:
  bool push(const Frame& frame) {
    const std::uint32_t head = head_;
    if (head - __atomic_load_n(&tail_, __ATOMIC_ACQUIRE) == N) return false;
    frames_[head % N] = frame;
    __atomic_store_n(&head_, head + 1U, __ATOMIC_RELEASE);
    return true;
  }
  bool pop(Frame& frame) {
    const std::uint32_t tail = tail_;
    if (__atomic_load_n(&head_, __ATOMIC_ACQUIRE) == tail) return false;
    frame = frames_[tail % N];
    __atomic_store_n(&tail_, tail + 1U, __ATOMIC_RELEASE);
    return true;
  }
  [[nodiscard]] std::uint32_t size() const {
    return __atomic_load_n(&head_, __ATOMIC_ACQUIRE) - __atomic_load_n(&tail_, __ATOMIC_ACQUIRE);
  }

 private:
  Frame frames_[N] = {};
  std::uint32_t head_ = 0;
  std::uint32_t tail_ = 0;
};

inline constexpr std::size_t kMailboxes = 3;           // of both controllers
inline constexpr std::size_t kFifoDepth = 3;           // likewise, each of two
inline constexpr std::size_t kInboxFrames = 128;       // a tick at 500 kbit/s carries 107 frames without data
inline constexpr std::size_t kOutboxFrames = 64;       // of two nodes on one board
inline constexpr std::size_t kFramesPerInterrupt = 2 * kFifoDepth;
static_assert(kOutboxFrames >= 2 * TxQueue::kCapacity);

using Inbox = FrameRing<kInboxFrames>;
using Outbox = FrameRing<kOutboxFrames>;

/// The bytes of a frame as two words, the first byte lowest, and back; bytes beyond dlc are zero.
inline std::uint32_t word_of(const Frame& frame, std::size_t first) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word |= std::uint32_t{frame.data[first + i]} << (8 * i);
  return word;
}
inline void put_word(Frame& frame, std::size_t first, std::uint32_t word) {
  for (std::size_t i = first; i < first + 4 && i < frame.dlc; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(word >> (8 * (i - first)));
  }
}
inline bool extended(const Frame& frame) { return (frame.id & Frame::kExtendedFlag) != 0; }

/// The seam to the bus before a controller of either kind: what goes out in a step, and what is too old to.
class CanController : public Can {
 public:
  std::size_t receive(Frame* frames, std::size_t capacity) override;
  /// Never waits. A step begins with receive(), and may send more than once, for more than one node. What is left of
  /// the step before is dropped first: a frame older than a step must not pass for a fresh one when the bus comes back.
  /// False when some frame was dropped, now or of the step before.
  bool send(const TxQueue& frames) override;

  [[nodiscard]] const CanCounts& counts() const { return counts_; }
  [[nodiscard]] bool bus_is_off() const { return off_; }

 protected:
  ~CanController() = default;

  /// From an interrupt: a frame that has come.
  void take(const Frame& frame);
  /// The frame to send next, if there is one. Not while send() has the interrupt of sending off, but for fill().
  bool next(Frame& frame);

  /// The rest is the controller's.
  virtual void let_sending_interrupt(bool on) = 0;
  /// Puts frames into the mailboxes that are free.
  virtual void fill() = 0;
  /// What waits in a mailbox; one that is on the bus this moment still goes out whole. Returns how many.
  virtual std::uint32_t abort_waiting() = 0;
  /// Once a step: counts, writes `off_`, goes on with the recovery and waits for none of it.
  virtual void leave_bus_off() = 0;

  CanCounts counts_{};
  bool ready_ = false;
  bool off_ = false;

 private:
  bool drop_old();

  Inbox inbox_{};
  Outbox outbox_{};
  bool new_step_ = true;  ///< the first send since frames were taken
};

}  // namespace voltlap::port::stm32
