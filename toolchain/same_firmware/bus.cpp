// SPDX-License-Identifier: Apache-2.0
#include "bus.hpp"

#include <algorithm>
#include <iterator>

#include "can_dbc/car.hpp"
#include "can_dbc/tables.hpp"

namespace same_firmware {
namespace {

using voltlap::Frame;
namespace can = voltlap::can;

constexpr std::size_t kFramesMax = 100;  // in a tick; what a delay releases beyond is lost
// Most identifiers of the bus are cell voltages; half of the damage goes to these.
constexpr std::uint32_t kOftenHarmed[] = {can::PackSensor::kId,     can::Pedals::kId,
                                          can::InverterStatus::kId, can::VehicleIo::kId,
                                          can::BmsLimits::kId,      can::BmsStatus::kId,
                                          can::MasterStatus::kId,   can::MotorTemperatures::kId,
                                          can::CellVoltages::kBaseId, can::Temperatures::kBaseId};

}  // namespace

Frame frame_of(const WireFrame& wire) {
  Frame frame;
  frame.id = wire.id;
  frame.dlc = wire.dlc;
  std::copy(std::begin(wire.data), std::end(wire.data), frame.data);
  return frame;
}

void Bus::plant_damage() {
  const auto kind = static_cast<Kind>(draw_.below(7));
  const std::uint32_t id = can::kMessages[draw_.below(std::size(can::kMessages))].id;
  Damage damage{kind, id, id, draw_.duration(draw_.chance(0.2) ? 300 : 8)};
  if (draw_.chance(0.5)) damage.first_id = damage.last_id = draw_.of(kOftenHarmed);
  if (draw_.chance(0.1)) damage = {kind, can::BmsLimits::kId, can::BmsStatus::kId, damage.ticks_left};
  if (draw_.chance(0.05)) damage = {kind, 0, 0x7FF, damage.ticks_left};
  damages_.push_back(damage);
}

void Bus::begin_tick() {
  frames_.clear();
  for (Damage& damage : damages_) --damage.ticks_left;
  std::erase_if(damages_, [](const Damage& damage) { return damage.ticks_left <= 0; });
  if (damages_.empty()) remembered_.clear();
  if (held_back_.empty() || draw_.chance(0.5)) return;
  for (const Frame& frame : held_back_) deliver(frame);
  held_back_.clear();
}

void Bus::forward(std::span<const WireFrame> frames) {
  for (const WireFrame& wire : frames) pass(frame_of(wire));
}

void Bus::pass(const Frame& frame) {
  const auto damage = std::find_if(damages_.begin(), damages_.end(), [&frame](const Damage& d) {
    return d.first_id <= frame.id && frame.id <= d.last_id;
  });
  if (damage == damages_.end()) {
    deliver(frame);
  } else {
    harm(*damage, frame);
  }
}

void Bus::deliver(const Frame& frame) {
  if (frames_.size() >= kFramesMax) return;
  WireFrame wire;
  wire.id = frame.id;
  wire.dlc = frame.dlc;
  std::copy(std::begin(frame.data), std::end(frame.data), wire.data);
  frames_.push_back(wire);
}

void Bus::harm(const Damage& damage, Frame frame) {
  switch (damage.kind) {
    case Kind::kLost: return;
    case Kind::kRepeated: deliver(remembered_.try_emplace(frame.id, frame).first->second); return;
    case Kind::kDelayed: held_back_.push_back(frame); return;
    case Kind::kCorrupt: {
      std::uint8_t& byte = frame.data[draw_.below(Frame::kMaxBytes)];
      byte = static_cast<std::uint8_t>(byte ^ (1U << draw_.below(8)));
      break;
    }
    case Kind::kWrongLength: frame.dlc = static_cast<std::uint8_t>(draw_.below(9)); break;
    case Kind::kGarbage: {
      const std::uint8_t counter = voltlap::codec::counter_of(frame);
      const bool full = draw_.chance(0.2);
      for (std::uint8_t& byte : frame.data) byte = static_cast<std::uint8_t>(full ? 0xFFU : draw_.next());
      voltlap::codec::seal(frame, counter);
      break;
    }
    case Kind::kTwice: deliver(frame); break;
  }
  deliver(frame);
}

}  // namespace same_firmware
