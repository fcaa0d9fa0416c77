// SPDX-License-Identifier: Apache-2.0
// The frames of four AMK inverters: four of one shape a message, for front left, front right, rear left and rear right.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/can_frame.hpp"
#include "can_dbc/amk.hpp"

namespace voltlap::codec {

inline constexpr std::size_t kWheels = 4;

/// One shape stands for the four messages of it.
template <class First>
struct AmkIds;
template <>
struct AmkIds<can::AmkSetpointsFrontLeft> {
  static constexpr std::uint32_t kId[kWheels] = {
      can::AmkSetpointsFrontLeft::kId, can::AmkSetpointsFrontRight::kId, can::AmkSetpointsRearLeft::kId,
      can::AmkSetpointsRearRight::kId};
};
template <>
struct AmkIds<can::AmkActual1FrontLeft> {
  static constexpr std::uint32_t kId[kWheels] = {can::AmkActual1FrontLeft::kId, can::AmkActual1FrontRight::kId,
                                                 can::AmkActual1RearLeft::kId, can::AmkActual1RearRight::kId};
};
template <>
struct AmkIds<can::AmkActual2FrontLeft> {
  static constexpr std::uint32_t kId[kWheels] = {can::AmkActual2FrontLeft::kId, can::AmkActual2FrontRight::kId,
                                                 can::AmkActual2RearLeft::kId, can::AmkActual2RearRight::kId};
};
using AmkSetpoints = can::AmkSetpointsFrontLeft;
using AmkActual1 = can::AmkActual1FrontLeft;
using AmkActual2 = can::AmkActual2FrontLeft;

/// The wheel whose message this is; kWheels when it is another.
template <class Message>
[[nodiscard]] constexpr std::size_t amk_wheel(std::uint32_t id) {
  std::size_t wheel = 0;
  while (wheel < kWheels && AmkIds<Message>::kId[wheel] != id) ++wheel;
  return wheel;
}

template <class Message>
[[nodiscard]] bool decode_amk(const Frame& frame, std::size_t& wheel, Message& m) {
  wheel = amk_wheel<Message>(frame.id);
  if (wheel == kWheels) return false;
  Frame first = frame;
  first.id = Message::kId;
  return decode(first, m);
}

template <class Message>
void encode_amk(const Message& m, std::size_t wheel, Frame& frame) {
  encode(m, frame);
  frame.id = AmkIds<Message>::kId[wheel];
}

/// The frames of amk.dbc, setpoints and DC link included.
[[nodiscard]] constexpr bool is_amk(std::uint32_t id) {
  return id == can::DcLinkSensor::kId || amk_wheel<AmkSetpoints>(id) < kWheels ||
         amk_wheel<AmkActual1>(id) < kWheels || amk_wheel<AmkActual2>(id) < kWheels;
}

/// [mA] of a code of AmkActual1.TorqueCurrent, 107.2 A / 16384 each.
[[nodiscard]] constexpr std::int32_t amk_current_ma(std::int32_t code) {
  return static_cast<std::int32_t>(std::int64_t{code} * 107'200 / 16'384);
}

}  // namespace voltlap::codec
