// SPDX-License-Identifier: Apache-2.0
// The unit of a clock that has none, from the battery that was recorded.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "core/demand.hpp"
#include "core/signal.hpp"
#include "io/logs/battery_pair.hpp"

namespace voltlap::plant {

namespace {

/// V = a - R I - s Q by least squares over the rows, Q in amperes times the clock's unit.
class DropFit {
 public:
  void add(double i, double q, double v) {
    ++count_;
    i_ += i, q_ += q, v_ += v;
    ii_ += i * i, iq_ += i * q, qq_ += q * q, iv_ += i * v, qv_ += q * v;
  }
  /// R / s in the clock's unit, or what it is at least where the fall with the charge is not seen; 0 for neither.
  struct Turn {
    double value = 0.0, least = 0.0;
  };
  [[nodiscard]] Turn turn() const {
    constexpr double kLeastRows = 100.0, kApart = 1e-6, kSeen = 0.1;
    if (count_ < kLeastRows) return {};
    const double ii = ii_ - i_ * i_ / count_, iq = iq_ - i_ * q_ / count_, qq = qq_ - q_ * q_ / count_;
    const double iv = iv_ - i_ * v_ / count_, qv = qv_ - q_ * v_ / count_, det = ii * qq - iq * iq;
    if (!(det > kApart * ii * qq)) return {};
    const double by_current = (iv * qq - qv * iq) / det, by_charge = (qv * ii - iv * iq) / det;
    // The fall with the charge must be seen at all: as much as a tenth of what the current does.
    const bool seen = std::abs(by_charge) * std::sqrt(qq) > kSeen * std::abs(by_current) * std::sqrt(ii);
    if (!seen) return {0.0, std::sqrt(qq / ii) / kSeen};
    return {std::max(0.0, by_current / by_charge), 0.0};
  }

 private:
  double count_ = 0, i_ = 0, q_ = 0, v_ = 0, ii_ = 0, iq_ = 0, qq_ = 0, iv_ = 0, qv_ = 0;
};

DropFit::Turn turn_of(const RecordedSignal& clock, const RecordedSignal& current, const RecordedSignal& voltage) {
  VOLTLAP_DEMAND(clock.value.size() == current.value.size() && clock.value.size() == voltage.value.size());
  DropFit fit;
  double drawn = 0.0, last_time = std::numeric_limits<double>::quiet_NaN(), last_current = 0.0;
  for (std::size_t row = 0; row < clock.value.size(); ++row) {
    const double t = clock.value[row], i = current.value[row], v = voltage.value[row];
    if (!std::isfinite(t) || !std::isfinite(i) || !std::isfinite(v)) continue;
    if (std::isfinite(last_time)) drawn += 0.5 * (i + last_current) * std::max(0.0, t - last_time);
    last_time = t;
    last_current = i;
    fit.add(i, drawn, v);
  }
  return fit.turn();
}

/// The unit in which a clock counts from 1970; nullptr for one that does not. A counter of microseconds since it was
/// switched on runs on by a large part of what it shows.
const char* unit_since_1970(const RecordedSignal& clock) {
  constexpr double kFirst_s = 1e9, kLast_s = 4e9, kShort = 0.01;  // 2001 to 2096; of it, four months
  std::vector<double> all;
  std::copy_if(clock.value.begin(), clock.value.end(), std::back_inserter(all),
               [](double stamp) { return std::isfinite(stamp); });
  if (all.empty()) return nullptr;
  const double middle = median(all);
  if (std::abs(all.back() - all.front()) > kShort * middle) return nullptr;
  for (const auto& [unit, seconds] : {std::pair{"s", 1.0}, {"ms", 1e-3}}) {
    if (within(middle * seconds, kFirst_s, kLast_s)) return unit;
  }
  return nullptr;
}

}  // namespace

TimeUnits time_units(const RecordedSignals& recording, const RecordedSignal& clock, const BatteryPair& pair) {
  constexpr double kLeast = 10.0, kLeastClear = 40.0, kMostClear = 1200.0, kMost = 5000.0;  // s
  TimeUnits out{{}, "nothing in the recording tells it"};
  if (const char* unit = recording.is_can ? nullptr : unit_since_1970(clock)) return {{unit}, "counts since 1970"};
  if (pair.current == nullptr || pair.voltage == nullptr || !pair.is_clear || recording.is_can) return out;
  const double turn = turn_of(clock, *pair.current, *pair.voltage).value;
  if (!(turn > 0.0)) return out;
  bool clear = false;
  for (const auto& [unit, seconds] : {std::pair{"s", 1.0}, {"ms", 1e-3}, {"min", 60.0}, {"h", 3600.0}}) {
    if (!within(turn * seconds, kLeast, kMost)) continue;
    out.possible.emplace_back(unit);
    clear = within(turn * seconds, kLeastClear, kMostClear);
  }
  out.why = fmt::format("the voltage falls by its own drop within {:.3g} of them", turn);
  if (out.possible.size() == 1 && !clear) out.possible.clear();
  return out;
}

bool is_in_milliseconds(const RecordedSignal& clock, const RecordedSignal& current, const RecordedSignal& voltage) {
  constexpr double kNever = 1e5, kHardly = 2e4;  // s; a cold cell with a flat curve (LFP) reaches 1e4
  constexpr double kSlow_s = 5.0;                // few loggers of a car write as seldom
  constexpr double kDrive_s = 30.0 * 86400.0, kQuick = 5e3;  // no drive lasts a month; s
  const auto [turn, least] = turn_of(clock, current, voltage);
  const double evidence = std::max(turn, least);
  const bool whole = std::all_of(clock.value.begin(), clock.value.end(),
                                 [](double stamp) { return !std::isfinite(stamp) || stamp == std::floor(stamp); });
  const double length = clock.value.empty() ? 0.0 : clock.value.back() - clock.value.front();
  return evidence > kNever || (length > kDrive_s && evidence > kQuick) ||
         (evidence > kHardly && whole && median(differences(clock.value)) >= kSlow_s);
}

}  // namespace voltlap::plant
