// SPDX-License-Identifier: Apache-2.0
// Which frames the car's inverters speak.
#pragma once
#include <cstdint>

namespace voltlap {

enum class InverterProtocol : std::uint8_t {
  kPhaseCurrent = 0,  ///< InverterCommand and InverterStatus of car.dbc
  kPm100 = 1,         ///< torque commands of a Cascadia PM100, pm100.dbc
  kAmk = 2,           ///< setpoints of four AMK inverters, amk.dbc
};

}  // namespace voltlap
