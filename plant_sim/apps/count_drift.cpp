// SPDX-License-Identifier: Apache-2.0
#include "apps/count_drift.hpp"

#include <algorithm>
#include <cmath>

#include "core/demand.hpp"

namespace voltlap::plant {
namespace {

constexpr double kSecondsPerHour = 3600.0;
constexpr double kSettled_s = 600.0;
constexpr double kAlike_v = 0.005;
constexpr double kReading_v = 0.002, kRelaxed = 0.002;  // what such rests differ by: V, and of the charge
constexpr double kSteep_v = 0.5;  // of OCV over the charge: where it is flatter, rests that end alike may lie far apart
constexpr double kSure = 3.0;
constexpr double kMost = 0.01;  // of the largest current: a counter that is further off is no instrument

struct Rest {
  double volts, drawn_ah, hours_on;
  bool after_discharge;
};

/// Hours under current up to each row.
std::vector<double> hours_on(const CellLog& log, double rest_a) {
  std::vector<double> out(log.rows(), 0.0);
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const bool on = std::max(std::abs(log.current_a[row - 1]), std::abs(log.current_a[row])) > rest_a;
    const double dt = log.gap[row] || !on ? 0.0 : log.time_s[row] - log.time_s[row - 1];
    out[row] = out[row - 1] + dt / kSecondsPerHour;
  }
  return out;
}

/// The state of each rest ten minutes after its current ended.
std::vector<Rest> rests_of(const CellLog& log, const std::vector<double>& drawn_ah, const std::vector<double>& on,
                           double rest_a) {
  std::vector<Rest> out;
  std::optional<std::size_t> began;  // the last row under current
  bool taken = true;
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (log.gap[row] || std::abs(log.current_a[row]) > rest_a) {
      began = log.gap[row] ? std::nullopt : std::optional(row);
      taken = false;
      continue;
    }
    if (taken || !began || std::isnan(log.voltage_v[row])) continue;
    if (log.time_s[row] - log.time_s[*began] < kSettled_s) continue;
    taken = true;
    out.push_back({log.voltage_v[row], drawn_ah[row], on[row], log.current_a[*began] > 0.0});
  }
  return out;
}

}  // namespace

std::optional<CountDrift> count_drift(const CellLog& log, const std::vector<double>& drawn_ah,
                                      const CellTables& tables, const CountedCell& cell) {
  VOLTLAP_DEMAND(drawn_ah.size() == log.rows() && cell.capacity_ah > 0.0 && cell.rest_a >= 0.0);
  const std::vector<double> on = hours_on(log, cell.rest_a);
  const std::vector<Rest> rests = rests_of(log, drawn_ah, on, cell.rest_a);
  double product = 0.0, square = 0.0;
  std::vector<bool> alike(rests.size(), false);
  for (std::size_t j = 1; j < rests.size(); ++j) {
    for (std::size_t i = 0; i < j; ++i) {
      const double hours = rests[j].hours_on - rests[i].hours_on, apart_v = rests[i].volts - rests[j].volts;
      if (rests[i].after_discharge != rests[j].after_discharge || hours <= 0.0) continue;
      if (std::abs(apart_v) > kAlike_v) continue;
      const double middle_v = 0.5 * (rests[i].volts + rests[j].volts);
      const double slope_v = tables.ocv(tables.soc_of_ocv(middle_v, cell.temperature_c)).slope_v;
      if (slope_v < kSteep_v) continue;
      const double drift = (rests[j].drawn_ah - rests[i].drawn_ah) / cell.capacity_ah - apart_v / slope_v;
      const double sure = 1.0 / (kRelaxed * kRelaxed + kReading_v * kReading_v / (slope_v * slope_v));
      product += sure * hours * drift;
      square += sure * hours * hours;
      alike[i] = alike[j] = true;
    }
  }
  if (square <= 0.0) return std::nullopt;
  const double rate = product / square;  // of the charge, an hour
  if (std::abs(rate) < kSure / std::sqrt(square)) return std::nullopt;
  double most_a = 0.0;
  for (const double current : log.current_a) most_a = std::max(most_a, std::abs(current));
  if (std::abs(rate) * cell.capacity_ah > kMost * most_a) return std::nullopt;
  CountDrift out{rate * cell.capacity_ah, static_cast<int>(std::count(alike.begin(), alike.end(), true)), drawn_ah};
  for (std::size_t row = 0; row < log.rows(); ++row) out.drawn_ah[row] -= out.current_a * on[row];
  return out;
}

}  // namespace voltlap::plant
