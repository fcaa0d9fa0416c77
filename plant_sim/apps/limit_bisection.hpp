// SPDX-License-Identifier: Apache-2.0
// The equations of firmware/bms/limits/horizon.hpp in double precision, solved by bisection: what the integers are held
// against. It shares the curves of the filter's CellModel with them, and no line of code.
#pragma once
#include "bms/config.hpp"
#include "bms/limits/horizon.hpp"

namespace voltlap::plant {

class LimitBisection {
 public:
  /// `warmer`: than the pack [0.1 K].
  LimitBisection(const bms::Config& config, const bms::SocFilter& filter, std::size_t cell, Duration horizon,
                 std::int32_t warmer = 0);

  /// Voltage at the end [V] of a constant current [mA, discharge positive].
  [[nodiscard]] double end_v(double ma) const;
  /// Size of the current, 0 .. most_ma: the largest at whose end voltage and charge are within their bounds.
  [[nodiscard]] double current_ma(const bms::HorizonBound& bound) const;

 private:
  [[nodiscard]] double fade() const;

  const bms::CellModel& model_;
  const bms::PartFactors& warm_;
  const bms::CellFilter& filter_;
  double share_;  ///< of the charge, by a milliampere
  double ms_;
  double rise_;   ///< kelvin by a watt until then
  std::int32_t heat_of_;  ///< the pack [0.1 degC]
  double temperature_c_;
};

}  // namespace voltlap::plant
