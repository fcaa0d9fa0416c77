// SPDX-License-Identifier: Apache-2.0
#include "race/limit_reason.hpp"

#include <iterator>

#include "can_dbc/car.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kOfBms = std::size(can::kLimitReasonNames);
constexpr std::size_t kReasonCharge = kOfBms, kReasonPower = kOfBms + 1, kReasonTemperature = kOfBms + 2,
                      kReasonSpeed = kOfBms + 3;
static_assert(kReasonSpeed + 1 == kLimitReasons);

}  // namespace

const char* limit_reason_name(std::size_t reason) {
  static constexpr const char* kNames[kLimitReasons] = {
      "none",         "config_maximum", "cell_voltage",     "pack_voltage",    "temperature",
      "soc_low",      "fault",          "measurement_lost", "contactors_open", "charging",
      "energy_to_go", "charge_limit",   "power",            "motor_temperature", "motor_speed"};
  return reason < kLimitReasons ? kNames[reason] : "unknown";
}

std::size_t binding_limit_reason(const CommandReceiver& ecus) {
  switch (ecus.master().torque_reason) {
    case can::TorqueReason::kDischargeLimit: return static_cast<std::size_t>(ecus.limits().discharge_reason);
    case can::TorqueReason::kChargeLimit: return kReasonCharge;
    case can::TorqueReason::kPower: return kReasonPower;
    case can::TorqueReason::kTemperature: return kReasonTemperature;
    case can::TorqueReason::kMotorSpeed: return kReasonSpeed;
    case can::TorqueReason::kNone:
    case can::TorqueReason::kGate: break;
  }
  return 0;
}

}  // namespace voltlap::plant
