// SPDX-License-Identifier: Apache-2.0
// The bus of a run: seals what the car sends, and now and then loses, repeats, delays or damages what passes.
#pragma once
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

#include "base/can_frame.hpp"
#include "codec/seal.hpp"
#include "draw.hpp"
#include "node_api.hpp"

namespace same_firmware {

class Bus {
 public:
  explicit Bus(Draw& draw) : draw_(draw) {}

  /// A damage of a drawn kind, to one identifier or to all that a node sends, for a drawn time.
  void plant_damage();
  void begin_tick();
  /// A message of the car.
  template <class Message>
  void send(const Message& message) {
    voltlap::Frame frame;
    encode(message, frame);
    sealer_.seal(frame);
    pass(frame);
  }
  /// Frames of a node, sealed by itself.
  void forward(std::span<const WireFrame> frames);
  /// In order of arrival, since the tick began.
  [[nodiscard]] std::span<const WireFrame> frames() const { return frames_; }

 private:
  enum class Kind : std::uint8_t { kLost, kRepeated, kDelayed, kCorrupt, kWrongLength, kGarbage, kTwice };
  struct Damage {
    Kind kind;
    std::uint32_t first_id, last_id;
    std::int32_t ticks_left;
  };

  void pass(const voltlap::Frame& frame);
  void deliver(const voltlap::Frame& frame);
  void harm(const Damage& damage, voltlap::Frame frame);

  Draw& draw_;
  voltlap::codec::Sealer sealer_;
  std::vector<Damage> damages_;
  std::vector<voltlap::Frame> held_back_;
  std::unordered_map<std::uint32_t, voltlap::Frame> remembered_;
  std::vector<WireFrame> frames_;
};

[[nodiscard]] voltlap::Frame frame_of(const WireFrame& wire);

}  // namespace same_firmware
