// SPDX-License-Identifier: Apache-2.0
#include "master/torque_split.hpp"

namespace voltlap::master {
namespace {

constexpr std::int64_t kFull = 1'000'000;

Current cut(std::int64_t ma, Current most) { return max(min(Current::saturated(ma), most), -most); }

}  // namespace

WheelCurrents split_torque(const Config& config, Current all) {
  const Ratio share = all >= Current{} ? config.front_drive_share : config.front_brake_share;
  const Current most = config.motor_current_max;
  const Current front = cut(std::int64_t{all.raw()} * share.raw() / kFull / 2, most);
  const Current rear = cut(std::int64_t{all.raw()} * (kFull - share.raw()) / kFull / 2, most);
  return {{front, front, rear, rear}};
}

}  // namespace voltlap::master
