// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "bms/estimate/soc_record.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kUnjudged = 0.1;      // of the charge, the first that moves
constexpr double kStep_s = 0.1;        // the longest step that the estimators see
constexpr double kRestShare = 0.02;    // of the capacity in an hour: at more current nothing rests
constexpr double kDoubtedVolts = 0.005;
constexpr double kOffPoints = 20.0;

/// One estimator fed with samples in the place of frames.
class Fed {
 public:
  /// From the open-circuit voltage, or from a record so far off under load: at rest it would be corrected.
  Fed(const bms::Config& config, bms::SocMethod method, std::optional<double> start_points, double true_soc)
      : config_(config) {
    config_.soc_method = method;
    if (!start_points) return;
    bms::SocRecord record;
    record.cells = 1;
    record.cell[0].soc = static_cast<std::int16_t>(std::lround(16'384.0 * (true_soc + 1e-2 * *start_points)));
    bms::restore(config_, record, state_);
    under_load_ = true;
  }

  void step(Instant now, double a, double v, double c) {
    if (under_load_ && std::abs(a) <= 1e-3 * config_.soc_start_current.raw()) return;
    under_load_ = false;
    const Current current = Current::saturated(std::lround(1e3 * a));
    const Sample<CellVoltage> cell{CellVoltage::saturated(std::lround(1e4 * v)), now, Quality::kGood};
    const Temperature t = Temperature::saturated(std::lround(10.0 * c));
    bms::estimate_soc(config_, {&cell, true, {current, now, Quality::kGood}, &current, now, t, true}, state_);
  }
  void judge(double true_soc) {
    if (state_.valid) score.add(100.0 * (1e-6 * state_.value.raw() - true_soc));
  }

  SocScore score;

 private:
  bms::Config config_;
  bms::SocEstimate state_{};
  bool under_load_ = false;
};

CurrentHold hold_of(const CellLog& log) {
  const auto counted = hold_from_counter(log);
  return counted.empty() ? CurrentHold::kPrevious : counted[0].hold;
}

double held_current(const CellLog& log, std::size_t row, double share, CurrentHold hold) {
  const double from = log.current_a[row - 1], to = log.current_a[row];
  if (hold == CurrentHold::kLinear) return from + share * (to - from);
  return hold == CurrentHold::kNext || share >= 1.0 ? to : from;
}

double temperature_at(const CellLog& log, std::size_t row, double otherwise_c) {
  return log.temperature_c.empty() || std::isnan(log.temperature_c[row]) ? otherwise_c : log.temperature_c[row];
}

double slope_bound(const CellTables& tables, double low, double high) {
  std::vector<double> slopes;
  for (int k = 0; k <= 100; ++k) slopes.push_back(tables.ocv(low + 0.01 * k * (high - low)).slope_v);
  std::sort(slopes.begin(), slopes.end());
  return 100.0 * kDoubtedVolts / std::max(slopes[10], 1e-3);
}

}  // namespace

SocRecordingResult run_soc_recording(const CellLog& log, const CellParameters& cell, const bms::Config& config) {
  if (std::isnan(log.voltage_v[0])) {
    throw InputError(log.path, "no voltage in its first row", "one: the truth is counted from it",
                     "Cut the file so that it begins with a voltage");
  }
  const CellTables tables(cell);
  const CurrentHold hold = hold_of(log);
  const std::vector<double> drawn_ah = charge_drawn_ah(log, hold);
  SocRecordingResult out;
  out.file = log.path;
  const double c = temperature_at(log, 0, cell.reference_temperature_c), a = log.current_a[0];
  const bool rests = std::abs(a) <= kRestShare * cell.capacity_ah;
  // A discharge test begins rested, and its first row may stand under the current already.
  out.begin_soc = tables.soc_of_ocv(log.voltage_v[0] + a * tables.circuit(1.0, c, std::abs(a)).r0_ohm, c);
  std::vector<std::string> names;
  std::vector<Fed> fed;
  const std::optional<double> known = rests ? std::nullopt : std::optional(0.0);
  // A charge begins near empty: no record can be lower by as much there.
  const double off = 100.0 * out.begin_soc < kOffPoints ? kOffPoints : -kOffPoints;
  for (const std::optional<double> start : {known, std::optional(off)}) {
    names.push_back(start == known ? "as recorded" : fmt::format("start {:+.0f} points", off));
    fed.emplace_back(config, bms::SocMethod::kEkf, start, out.begin_soc);
    fed.emplace_back(config, bms::SocMethod::kCoulomb, start, out.begin_soc);
  }
  double clock_ms = 0.0, volts = log.voltage_v[0];
  bool judged = false;
  for (std::size_t row = 1; row < log.rows(); ++row) {
    const double dt = log.time_s[row] - log.time_s[row - 1];
    const double before_v = volts;
    if (!std::isnan(log.voltage_v[row])) volts = log.voltage_v[row];
    const double truth = out.begin_soc - drawn_ah[row] / cell.capacity_ah;
    judged = judged || std::abs(truth - out.begin_soc) > kUnjudged;
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / kStep_s)));
    for (int k = 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      clock_ms += 1e3 * dt / steps;
      const Instant now = Instant::from_ms(static_cast<std::uint32_t>(std::llround(std::fmod(clock_ms, 4294967296.0))));
      const double v = hold == CurrentHold::kLinear ? before_v + share * (volts - before_v) : volts;
      for (Fed& each : fed) {
        each.step(now, held_current(log, row, share, hold), k == steps ? volts : v,
                  temperature_at(log, row, cell.reference_temperature_c));
      }
    }
    if (!judged) continue;
    out.low_soc = std::min(out.low_soc, truth);
    out.high_soc = std::max(out.high_soc, truth);
    out.judged_s += dt;
    for (Fed& each : fed) each.judge(truth);
  }
  if (!judged) {
    throw InputError(log.path, "less than a tenth of the charge moves", "a recording in which more does",
                     "Give a discharge or a drive");
  }
  out.slope_bound_points = slope_bound(tables, std::max(0.0, out.low_soc), std::min(1.0, out.high_soc));
  for (std::size_t k = 0; k < names.size(); ++k) out.rows.push_back({names[k], fed[2 * k].score, fed[2 * k + 1].score});
  return out;
}

}  // namespace voltlap::plant
