// SPDX-License-Identifier: Apache-2.0
#include "car/battery/parameter_map.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "car/battery/cell_effects.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
std::string place_in(const CellParameters& cell, const std::string& field) {
  return fmt::format("cell {}, {}", cell.name, field);
}

void require_increasing(const CellParameters& cell, const char* key, const std::vector<double>& values) {
  if (values.empty()) {
    throw InputError(place_in(cell, key), "an empty list", "at least one breakpoint",
                     "Add the value at which the tables hold");
  }
  for (std::size_t i = 1; i < values.size(); ++i) {
    if (!(values[i] > values[i - 1])) {
      throw InputError(place_in(cell, key), fmt::format("{} after {}", values[i], values[i - 1]),
                       "each breakpoint greater than the one before", "Put the points in order");
    }
  }
}

double exchange_current_of(const CellParameters& cell, double temperature_c) {
  return cell.r0_ohm.exchange_current_a *
         arrhenius(-cell.r0_ohm.exchange_activation_energy_j_per_mol, temperature_c, cell.reference_temperature_c);
}

namespace {

/// What the charge transfer adds to a parameter [ohm] at a temperature and current.
double charge_transfer_ohm(const CellParameters& cell, const CellParameterMap& map, double temperature_c,
                           double current_a) {
  constexpr double kSmall = 1e-3;  // of the exchange current: below it v_ct / I does not change
  if (map.exchange_current_a == 0.0) return 0.0;
  const double exchange = exchange_current_of(cell, temperature_c);
  const double current = std::max(std::abs(current_a), kSmall * exchange);
  return charge_transfer_v(exchange, current, temperature_c) / current;
}

}  // namespace

std::vector<double> expand(const CellParameters& cell, const std::string& key, const CellParameterMap& map) {
  const auto& soc = cell.soc_breakpoints;
  const auto& temperature = cell.temperature_breakpoints_c;
  const auto& current = cell.current_breakpoints_a;
  const std::size_t nodes = soc.size() * temperature.size() * current.size();
  std::vector<double> table = map.table;
  if (table.empty()) {
    if (map.value.size() != soc.size()) {
      throw InputError(place_in(cell, fmt::format("{}.value", key)), fmt::format("{} values", map.value.size()),
                       fmt::format("{}, one for each point of breakpoints.soc", soc.size()),
                       "Give one value for every point");
    }
    table.reserve(nodes);
    for (const double value : map.value) {
      for (const double t : temperature) {
        const double by_temperature = (1.0 + map.per_kelvin * (t - cell.reference_temperature_c)) *
                                      arrhenius(map.activation_energy_j_per_mol, t, cell.reference_temperature_c);
        for (const double i : current) {
          table.push_back(value * by_temperature * (1.0 + map.per_ampere * (i - cell.reference_current_a)) +
                          charge_transfer_ohm(cell, map, t, i));
        }
      }
    }
  }
  if (table.size() != nodes) {
    throw InputError(place_in(cell, fmt::format("{}.table", key)), fmt::format("{} values", table.size()),
                     fmt::format("{}: {} SOC points times {} temperatures times {} currents", nodes, soc.size(),
                                 temperature.size(), current.size()),
                     "Give one value for every point");
  }
  for (std::size_t n = 0; n < nodes; ++n) {
    if (!(table[n] > 0.0) || !std::isfinite(table[n])) {
      const std::size_t per_soc = temperature.size() * current.size();
      throw InputError(place_in(cell, key),
                       fmt::format("{:g} at SOC {:g}, {:g} degC and {:g} A", table[n], soc[n / per_soc],
                                   temperature[n / current.size() % temperature.size()], current[n % current.size()]),
                       "more than 0 at every point of the table",
                       "Check the values, per_kelvin, per_ampere and the breakpoints");
    }
  }
  return table;
}

}  // namespace voltlap::plant
