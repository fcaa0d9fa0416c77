// SPDX-License-Identifier: Apache-2.0
// State of charge: one interface, the methods are sibling files (soc_none, soc_coulomb, soc_ekf) chosen by
// Config::soc_method.
#pragma once
#include <cstddef>
#include <cstdint>

#include "base/sample.hpp"
#include "base/units.hpp"
#include "bms/config.hpp"
#include "bms/estimate/soc_filter.hpp"

namespace voltlap::bms {

/// What every method gets, once a step.
struct SocInput {
  const Sample<CellVoltage>* cells = nullptr;  ///< config.cells_in_series of them
  bool cells_good = false;                     ///< every one
  Sample<Current> current{};                   ///< of the pack, discharge positive
  const Current* cell_current = nullptr;       ///< soc_ekf: that when a cell's voltage was read, one a cell
  Instant now{};                               ///< soc_ekf
  Temperature temperature{};                   ///< soc_ekf: of the cells
  bool temperature_known = false;
  const bool* bled = nullptr;                  ///< soc_ekf: a cell is read under a bleed, one a cell; null: none is
};

/// What every method leaves behind; a method uses the part it needs.
struct SocEstimate {
  Soc value{};
  bool valid = false;
  std::int64_t charge = 0;         ///< soc_coulomb, soc_ekf: charge left, in half mA ms (see there)
  Sample<Current> last_current{};  ///< the sample up to which charge is counted
  SocFilter filter{};              ///< soc_ekf
};

void estimate_soc(const Config& config, const SocInput& input, SocEstimate& state);

/// Limits and contactors may rely on the estimate, or the method says that there is none to wait for.
[[nodiscard]] bool soc_ready(const Config& config, const SocEstimate& state);

}  // namespace voltlap::bms
