// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/resistor_bank.hpp"

#include <fmt/format.h>

#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {

std::string BankChoice::name() const {
  return resistors == 0 ? fmt::format("low bank, {:.4g} ohm", resistance_ohm)
                        : fmt::format("{} of the high bank, {:.4g} ohm", resistors, resistance_ohm);
}

BankChoice high_bank(const LoadSection& load, int cells, int resistors) {
  VOLTLAP_DEMAND(load.high_bank_ohm > 0.0 && cells > 0 && resistors > 0);
  const double resistance = load.high_bank_ohm / resistors;
  return {resistors, resistance, load.nominal_cell_v * cells / resistance};
}

BankChoice choose_bank(const LoadSection& load, int cells, double current_a) {
  BankChoice best = high_bank(load, cells, 1);
  const auto consider = [&](const BankChoice& other) {
    if (std::abs(other.nominal_a - current_a) < std::abs(best.nominal_a - current_a)) best = other;
  };
  for (int n = 2; n <= load.high_bank_count; ++n) consider(high_bank(load, cells, n));
  if (load.low_bank_ohm > 0.0) consider({0, load.low_bank_ohm, load.nominal_cell_v * cells / load.low_bank_ohm});
  return best;
}

}  // namespace voltlap::plant
