// SPDX-License-Identifier: Apache-2.0
// Bus and clock of a board whose plant is at the other end of a stream. In every tick, as in can_dbc/lockstep.dbc:
//
//   plant   its frames, Sync
//   board   frames of the BMS, DoneBms, frames of the master, DoneMaster    (of the nodes that it has)
//
// In the place of a tick's batch the plant may send MemberReset: the board starts anew and greets again.
//
// One read and one write a tick. A node's loop is that of every other board: sleep_until(), receive(), send() once.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "can_dbc/lockstep.hpp"
#include "port/can.hpp"
#include "port/clock.hpp"
#include "port/image_info.hpp"
#include "port/lockstep/frame_bytes.hpp"
#include "port/lockstep/rig.hpp"

namespace voltlap::port {

class LockstepPort final : public Can, public Clock {
 public:
  /// Of the plant and, where the board has one node alone, of the other.
  static constexpr std::size_t kFramesInMax = 2 * TxQueue::kCapacity;

  LockstepPort(Rig& rig, const ImageInfo& image)
      : rig_(rig), image_(image), runs_bms_(image.has_bms), runs_master_(image.has_master) {}
  LockstepPort(const LockstepPort&) = delete;
  LockstepPort& operator=(const LockstepPort&) = delete;

  /// Greets the plant. `bms` and `master` null: the image has its own configuration. Else they are filled with what
  /// the plant sends; an image that is handed another layout ends.
  void greet(void* bms, std::size_t bms_bytes, void* master, std::size_t master_bytes, std::size_t temperatures_max);

  /// In the place of greet(), for a board on a bus that all members of a lockstep share: READY is all they say.
  void join() { greeted_ = true; }

  /// The nodes that this board steps: those of the image, unless the plant wants one of them alone.
  [[nodiscard]] bool runs_bms() const { return runs_bms_; }
  [[nodiscard]] bool runs_master() const { return runs_master_; }

  [[nodiscard]] Instant now() const override { return now_; }
  /// Sends what the nodes did in the tick before, and takes the next one. Ends the run when the plant does.
  void sleep_until(Instant at) override;

  std::size_t receive(Frame* frames, std::size_t capacity) override;
  /// Of the BMS first, then of the master.
  bool send(const TxQueue& frames) override;

 private:
  /// Frames of two nodes, a Done and a StepCost for each.
  static constexpr std::size_t kFramesOutMax = 2 * TxQueue::kCapacity + 4;

  void announce();
  void put(const Frame& frame);
  void flush();
  void take_batch();
  bool take_sync(const Frame& frame);
  void obey_reset(const Frame& frame);
  void fill_to(std::size_t bytes);
  void read_whole(void* to, std::size_t count);
  void report_stack();
  [[nodiscard]] can::Member member_of_turn() const;

  Rig& rig_;
  const ImageInfo& image_;
  bool runs_bms_, runs_master_;
  Instant now_{};
  std::uint32_t tick_ = 0;
  bool greeted_ = false, started_ = false;
  std::uint8_t turns_ = 0;                      ///< nodes that have sent in this tick
  std::uint32_t begin_ = 0;                     ///< of the step that is being counted [instructions]
  Frame in_[kFramesInMax] = {};
  std::size_t in_count_ = 0, in_taken_ = 0;
  std::uint8_t raw_[(kFramesInMax + 1) * kFrameBytes] = {};  ///< read ahead
  std::size_t raw_count_ = 0, raw_taken_ = 0;
  std::uint8_t out_[kFramesOutMax * kFrameBytes] = {};
  std::size_t out_count_ = 0;                   ///< [byte]
};

}  // namespace voltlap::port
