// SPDX-License-Identifier: Apache-2.0
// Units as files spell them, and what they measure.
#pragma once
#include <string>

namespace voltlap::plant {

struct SignalUnit {
  std::string text;      ///< as it is written here: "degC", "C" and "temperature:deg C" are °C
  std::string quantity;  ///< such as "Voltage"; empty: not known
  std::size_t rank = 0;  ///< in the order in which charts stand; those that are not known last
};

[[nodiscard]] SignalUnit signal_unit(const std::string& spelled);

}  // namespace voltlap::plant
