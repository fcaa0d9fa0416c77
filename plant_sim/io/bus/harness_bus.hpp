// SPDX-License-Identifier: Apache-2.0
// The bus inside a process, with a harness at the other end of two pipes: it sees every frame, may change what each
// node hears, and lets time go on tick by tick. No CAN interface and no privilege is needed.
//
// Everything is batches of 16-byte records, little-endian. A batch is its length in records (u32), a flag (u32) and the
// records: identifier (u32, bit 31 extended), length (u8), who (u8), two bytes of zero, eight bytes of data.
//   harness   batch: requests (lockstep.dbc) and frames of its own for the coming tick; flag 1: it is the gateway
//   car       without gateway: one batch, all frames of the tick, `who` the sender (0 plant, 1 BMS, 2 master)
//             with gateway: for plant, BMS and master in turn a batch of what it sent, and the harness's answer: what
//             is heard of it, `who` the hearers (bit 0 plant, bit 1 BMS, bit 2 master); then the tick is over
// The end of the harness's pipe, or its StopRequest, ends the run.
#pragma once
#include <array>
#include <cstdint>
#include <vector>

#include "io/bus/in_process_loop.hpp"
#include "io/bus/plant_bus.hpp"

namespace voltlap::plant {

/// Control units whose supply a harness may take away.
class SuppliedEcus : public Ecus {
 public:
  /// Off for good, as a node that has died.
  virtual void lose(Sender node) = 0;
  /// Off from `now` for so long; what the node keeps over a loss of its supply is all that it knows then.
  virtual void reset(Sender node, Instant now, Duration off) = 0;
};

class HarnessBus final : public PlantBus {
 public:
  /// Descriptors of the two pipes; both stay the caller's.
  HarnessBus(SuppliedEcus& ecus, int from_harness, int to_harness)
      : ecus_(ecus), from_harness_(from_harness), to_harness_(to_harness) {}

  void attach(FrameSink& sink) override { sinks_.push_back(&sink); }
  /// Waits for the harness. Throws BusFailure for what is no batch.
  const Interventions& begin_tick(std::uint32_t tick) override;
  FrameView exchange(const TxQueue& plant) override;
  [[nodiscard]] const std::vector<LostNode>& lost() const override { return lost_; }
  [[nodiscard]] StopAsked stop_asked() const override { return stop_; }
  [[nodiscard]] std::uint64_t frames_sent() const override { return frames_sent_; }
  [[nodiscard]] std::uint32_t frames_in_tick_max() const override { return frames_in_tick_max_; }

 private:
  struct Record {
    std::uint32_t id;
    std::uint8_t dlc, who;
    std::uint16_t zero;
    std::uint8_t data[Frame::kMaxBytes];
  };
  static_assert(sizeof(Record) == 16);

  /// False at the end of the pipe.
  [[nodiscard]] bool read_batch();
  void write_batch();
  void add(const Frame& frame, Sender sender);
  void request(const Frame& frame);
  void hear(const Frame& frame, unsigned hearers);
  /// What `sender` sent goes to the others, by way of the harness where that is the gateway.
  void pass_on(Sender sender, const TxQueue& frames);
  [[nodiscard]] FrameView heard_by(Sender node);

  SuppliedEcus& ecus_;
  int from_harness_, to_harness_;
  std::vector<FrameSink*> sinks_;
  std::vector<Record> batch_, out_;
  std::array<std::vector<Frame>, kSenders> inbox_, taken_;
  Interventions now_;
  std::vector<LostNode> lost_;
  StopAsked stop_ = StopAsked::kNo;
  std::uint32_t tick_ = 0, frames_in_tick_ = 0, frames_in_tick_max_ = 0;
  std::uint64_t frames_sent_ = 0;
  bool gateway_ = false;
};

}  // namespace voltlap::plant
