// SPDX-License-Identifier: Apache-2.0
// At random moments of a drive: what current each kind of limit would allow for a time, and where the cells of the
// plant are when just that has flowed.
#pragma once
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "bms/config.hpp"
#include "race/endurance.hpp"

namespace voltlap::plant {

inline constexpr std::size_t kTriedHorizons = 3;  // of bms::kLimitHorizons: what lasts for ever cannot be tried

/// One limit applied to the plant for its time.
struct LimitTrial {
  double limit_a = 0.0;
  bool by_voltage = false;   ///< a cell's voltage sets it, not a maximum, the charge or heat
  double inside_v = 0.0;     ///< the cell nearest to its bound at the end, inside of it; beyond it negative
};

/// One moment, direction and horizon.
struct LimitMoment {
  std::uint64_t seed = 0;    ///< of the drive
  double time_s = 0.0, soc = 0.0, temperature_c = 0.0;
  std::size_t horizon = 0;
  bool discharge = true;
  double bisected_a = 0.0;   ///< in double precision, from the same filter
  LimitTrial ahead, equation, table;
};

struct LimitDrive {
  EnduranceOptions options;
  std::uint64_t seed = 0;
  int moments = 0;           ///< of the drive, after its first two minutes
};

/// The drive is driven by the firmware with `bms.limit_method` ahead. `progress` is called with the fraction driven;
/// true stops the run.
[[nodiscard]] std::vector<LimitMoment> run_limit_drive(const LimitDrive& drive,
                                                       const std::function<bool(double)>& progress);

}  // namespace voltlap::plant
