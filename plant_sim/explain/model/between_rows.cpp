// SPDX-License-Identifier: Apache-2.0
#include "explain/model/between_rows.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "explain/balances/car_balances.hpp"
#include "explain/balances/counted_charge.hpp"

namespace voltlap::explain {
namespace {

/// RMS of what is off, where the current is even: a reading in which a load goes on or off may be off by all of it and
/// tells nothing of the others.
double rms_where_even(const VectorXd& off, const VectorXd& rough) {
  constexpr double kRough = 10.0;  // as the noise that grows with how fast the current changes
  const VectorXd weight = (1.0 + kRough * rough.array().square()).inverse();
  return std::sqrt(weight.dot(off.cwiseAbs2()) / std::max(1e-300, weight.sum()));
}

/// Every second row, from row `first` on, as if it had not been recorded.
void thin(VectorXd& values, Index first) {
  for (Index row = first; row + 1 < values.size(); row += 2) values(row) = 0.5 * (values(row - 1) + values(row + 1));
}

/// The mean current on the way to each row as the rows that `thin` leaves have it. Empty without a counter.
VectorXd thinned_count(VectorXd counted_a, Index first) {
  for (Index row = first; row + 1 < counted_a.size(); row += 2)
    counted_a(row) = counted_a(row + 1) = 0.5 * (counted_a(row) + counted_a(row + 1));
  return counted_a;
}

/// Facts without every second row, but for the heat of what was switched there: rows that are further apart tell it
/// as well as these do.
plant::LogFacts thinned_facts(plant::LogFacts facts, Index first) {
  const VectorXd recorded_a = facts.current_a;
  thin(facts.current_a, first);
  thin(facts.voltage_v, first);
  facts.counted_a = thinned_count(std::move(facts.counted_a), first);
  const VectorXd &current = facts.current_a, &counted = facts.counted_a;
  VectorXd beyond = VectorXd::Zero(current.size());
  const auto mean_a = [&](Index row) {
    const bool is_counted = counted.size() > 0 && std::isfinite(counted(row));
    return is_counted ? counted(row) : 0.5 * (current(row - 1) + current(row));
  };
  const auto put = [&](Index row, double square) {
    const double mean = mean_a(row), half_a = current(row) - mean;
    beyond(row) = square - mean * mean - half_a * half_a / 3.0;
  };
  for (Index row = 1; row < current.size(); ++row)
    put(row, plant::switched_square(current(row - 1), current(row), mean_a(row), facts.usual));
  for (Index row = first; row + 1 < current.size(); row += 2) {
    const double mean = 0.5 * (mean_a(row) + mean_a(row + 1));
    const double square = plant::switched_square(recorded_a(row - 1), recorded_a(row + 1), mean, facts.usual);
    put(row, square);
    put(row + 1, square);
  }
  facts.beyond_straight_a2 = std::move(beyond);
  return facts;
}

/// Predictions without every second row of what drives battery and car. A row beside which a pedal moved stays: what
/// was gained there is not judged.
plant::Prediction thinned_prediction(Observed& log, Index first) {
  std::map<std::string, VectorXd>& signals = log.comparison.log.signals;
  const std::vector<bool> knows = plant::knows_gain(log.comparison.log);
  std::map<std::string, VectorXd> driven_by;  // as it was recorded
  for (const char* role : {"current", "motor_torque", "accelerator", "brake", "lateral_acceleration"}) {
    const auto found = signals.find(role);
    if (found == signals.end()) continue;
    VectorXd& values = found->second;
    const VectorXd& recorded = driven_by[role] = values;
    thin(values, first);
    if (std::string_view(role) == "current") continue;
    for (std::size_t row = 0; row + 1 < knows.size(); ++row) {
      if (!knows[row] || !knows[row + 1]) values(static_cast<Index>(row)) = recorded(static_cast<Index>(row));
    }
  }
  plant::LogFacts recorded = thinned_facts(log.comparison.facts, first);
  std::swap(recorded, log.comparison.facts);
  plant::Prediction out = plant::predict(log.model, log.comparison);
  log.comparison.facts = std::move(recorded);
  for (auto& [role, values] : driven_by) signals[role] = std::move(values);
  return out;
}

}  // namespace

bool is_of_laboratory(const plant::Recording& log) {
  return log.find("voltage") != nullptr;
}

bool is_between_rows(const plant::Comparison& log) {
  // Of its RMS; a drive at 1 Hz has 0.9, at 10 Hz 0.3, at 100 Hz 0.1. One at 1 Hz that a small pack limits has 0.4, and
  // is switched between its rows all the same; a cell in a laboratory is not.
  constexpr double kMuch = 0.5, kOfSeldom = 0.35, kSeldom_s = 0.3;
  const VectorXd &current = log.facts.current_a, &time_s = log.log.time_s;
  const double row_s = (time_s(time_s.size() - 1) - time_s(0)) / static_cast<double>(time_s.size());
  const double much = row_s > kSeldom_s && !is_of_laboratory(log.log) ? kOfSeldom : kMuch;
  double off = 0.0, all = 0.0;
  for (Index row = 1; row + 1 < current.size(); ++row) {
    const double beside = current(row) - 0.5 * (current(row - 1) + current(row + 1));
    if (!std::isfinite(beside)) continue;
    off += beside * beside;
    all += current(row) * current(row);
  }
  return off > much * much * all;
}

namespace {

/// A test of pulses: the current stands but for a few rows. What its pulses would be longer without the one half they
/// would be shorter without the other.
bool is_of_pulses(const VectorXd& current) {
  constexpr double kStep = 0.1, kFew = 0.1;  // of the RMS; of the rows. A drive at 10 Hz moves in a third of them.
  const double rms = std::sqrt(current.squaredNorm() / static_cast<double>(current.size()));
  Index moves = 0;
  for (Index row = 1; row < current.size(); ++row)
    moves += std::abs(current(row) - current(row - 1)) > kStep * rms ? 1 : 0;
  return static_cast<double>(moves) < kFew * static_cast<double>(current.size());
}

/// Of the rows that either half leaves, without what one half has slowly more than the other; of pulses without all
/// that it has more.
VectorXd of_halves(const VectorXd& time_s, bool pulses, VectorXd odd_left_out, VectorXd even_left_out) {
  constexpr double kSlow_s = 30.0, kRows = 30.0;  // within which nothing is slow
  for (VectorXd* off : {&odd_left_out, &even_left_out}) *off = off->array().isFinite().select(*off, 0.0);
  VectorXd out = odd_left_out;
  for (Index row = 1; row < out.size(); row += 2) out(row) = even_left_out(row);
  thin(odd_left_out, 1);
  thin(even_left_out, 2);
  const double row_s = (time_s(time_s.size() - 1) - time_s(0)) / static_cast<double>(time_s.size());
  const double slow_s = pulses ? 0.0 : std::max(kSlow_s, kRows * row_s);
  const VectorXd apart = 0.5 * plant::smoothed(time_s, odd_left_out - even_left_out, slow_s);
  for (Index row = 0; row < out.size(); ++row) out(row) -= row % 2 == 0 ? apart(row) : -apart(row);
  return out;
}

/// What the mean cell's voltage may drift by [V RMS] where nothing counts the charge: a load that is switched anywhere
/// between two rows is as long as half of what is between them give or take dt / sqrt(12), and the sum of these errors
/// walks away: RMS sqrt(variance of the end / 6) once it began where the log does, in one log of twenty 1.7 times that.
double uncounted_drift_v(const Observed& log) {
  constexpr double kOneInTwenty = 1.7, kSecondsPerHour = 3600.0;
  const plant::LogFacts& facts = log.comparison.facts;
  if (facts.hold != plant::CurrentHold::kLinear || is_of_laboratory(log.comparison.log)) return 0.0;
  const VectorXd& time_s = log.comparison.log.time_s;
  double square_c2 = 0.0;
  for (Index row = 1; row < time_s.size(); ++row) {
    const double jump_c = (facts.current_a(row) - facts.current_a(row - 1)) * (time_s(row) - time_s(row - 1));
    if (std::isfinite(jump_c)) square_c2 += jump_c * jump_c / 12.0;
  }
  const double capacity_ah = log.model.car.cell.capacity_ah * log.model.car.battery.cells_in_parallel;
  const double soc = std::sqrt(square_c2 / 6.0) / (kSecondsPerHour * capacity_ah);
  return kOneInTwenty * soc * log.base.battery.ocv_slope_v.mean();
}

}  // namespace

void put_between_rows(Observed& log) {
  // Of what every second row tells: 0.6 of a current that is switched at any time, 0.75 of one that a limit chatters
  // with at 10 Hz (a sound pack of 133 cells). Where the current is another in each row these have lost more already
  // than half as many lose besides: 1.0, 1.35 and 1.6 times as much in three sound drives, and 0.8 of it is asked.
  const VectorXd& current = log.comparison.facts.current_a;
  const bool pulses = is_of_pulses(current);
  const double of_half = is_between_rows(log.comparison) ? 2.1 : pulses ? 0.5 : 0.75;
  const plant::Prediction odd_left_out = thinned_prediction(log, 1), even_left_out = thinned_prediction(log, 2);
  for (std::size_t c = 0; c < log.channels.size(); ++c) {
    ReadChannel& channel = log.channels[c];
    const VectorXd& base = log.base.channels[c];
    const VectorXd off = of_halves(log.comparison.log.time_s, pulses, odd_left_out.channels[c] - base,
                                   even_left_out.channels[c] - base);
    channel.between_rows = of_half * rms_where_even(channel.reader.of(off), channel.rough) / channel.practical;
  }
  if (log.comparison.facts.counted_a.size() == 0) {
    ReadChannel& main = log.channels.front();  // the others are told beside it
    const double in_series = main.name == "voltage" ? 1.0 : log.model.car.battery.cells_in_series;
    main.between_rows = std::hypot(main.between_rows, in_series * uncounted_drift_v(log) / main.practical);
  }
  if (!log.comparison.log.cells_apart) return;
  // Cells that were read at any time between two rows: half of what the voltage changed there.
  const VectorXd& volts = log.base.battery.voltage_v;
  VectorXd changed = VectorXd::Zero(volts.size());
  for (Index row = 1; row < volts.size(); ++row) changed(row) = 0.5 * std::abs(volts(row) - volts(row - 1));
  const auto put = [&](ReadChannel& channel) {
    const double cells = channel.name == "pack_voltage" ? log.model.car.battery.cells_in_series : 1.0;
    const VectorXd off = cells * channel.reader.of(changed);
    channel.between_rows = of_half * rms_where_even(off, channel.rough) / channel.practical;
    channel.apart = std::sqrt(off.squaredNorm() / std::max(1.0, static_cast<double>(off.size()))) / channel.practical;
  };
  for (ReadChannel& channel : log.channels) {
    const bool beside_cells = channel.name == "pack_voltage" && !log.comparison.log.pack_is_nearer;
    if (channel.name == "voltage" || beside_cells) put(channel);
  }
  for (Member& member : log.members) {
    if (member.channel.balance == plant::Balance::kVoltage) put(member.channel);
  }
}

}  // namespace voltlap::explain
