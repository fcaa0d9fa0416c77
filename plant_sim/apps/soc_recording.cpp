// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "apps/count_drift.hpp"
#include "bms/estimate/soc_record.hpp"
#include "core/errors.hpp"
#include "learn/validate/prediction_error.hpp"

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

struct Hold {
  CurrentHold hold;
  std::string from;
};

/// As validate finds it: by the recording's counter, else by its voltage.
Hold hold_of(const CellLog& log, const CellParameters& cell, double otherwise_c) {
  try {
    const PlacedRecording placed = place_recording(CellModel(cell), log, {otherwise_c, true});
    return {placed.options.hold, placed.hold_from};
  } catch (const InputError&) {  // it only charges: nothing that validate could judge
    const auto counted = hold_from_counter(log);
    if (!counted.empty()) return {counted[0].hold, "its counter"};
    return {CurrentHold::kNext, "habit: nothing is drawn"};
  }
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

/// The row from which the charge is counted: the first with a voltage.
std::size_t first_row(const CellLog& log) {
  for (std::size_t row = 0; row < log.rows(); ++row) {
    if (!std::isnan(log.voltage_v[row])) return row;
  }
  throw InputError(log.path, "no voltage", "one: the truth is counted from it",
                   "Give a recording of current and voltage");
}

/// One past the last row that the estimators can follow: before the first gap in which, as the recorder's counter has
/// it, charge flowed, or that has no counter.
std::size_t end_row(const CellLog& log, const std::vector<double>& drawn_ah, std::size_t first, double capacity_ah) {
  constexpr double kNothing = 0.001;  // of the capacity
  for (std::size_t row = first + 1; row < log.rows(); ++row) {
    if (!log.gap[row]) continue;
    if (log.charge_ah.empty() || std::abs(drawn_ah[row] - drawn_ah[row - 1]) > kNothing * capacity_ah) return row;
  }
  return log.rows();
}

/// What a reader must know of the rows from `first` to `end`.
std::vector<std::string> remarks_of(const CellLog& log, std::size_t first, std::size_t end, bool rests,
                                    double otherwise_c) {
  std::vector<std::string> out = log.repairs;
  const double a = log.current_a[first];
  if (!rests) out.push_back(fmt::format("begins under {:.4g} A: taken as rested before", a));
  if (log.temperature_c.empty()) out.push_back(fmt::format("no thermometer: {:.4g} degC", otherwise_c));
  if (end < log.rows()) {
    const double at_s = log.time_s[end - 1];
    out.push_back(fmt::format("ends at a gap at {:.1f} s, {:.0f} s before its end: the BMS cannot know what flowed",
                              at_s, log.time_s.back() - at_s));
  }
  return out;
}

/// The estimators beside each other, each with what it is called.
struct Listeners {
  std::vector<std::string> names;
  std::vector<Fed> fed;  ///< of each name the filter and the count

  Listeners(const bms::Config& config, bool rests, double begin_soc) {
    const std::optional<double> known = rests ? std::nullopt : std::optional(0.0);
    // A charge begins near empty: no record can be lower by as much there.
    const double off = 100.0 * begin_soc < kOffPoints ? kOffPoints : -kOffPoints;
    for (const std::optional<double> start : {known, std::optional(off)}) {
      names.push_back(start == known ? "as recorded" : fmt::format("start {:+.0f} points", off));
      fed.emplace_back(config, bms::SocMethod::kEkf, start, begin_soc);
      fed.emplace_back(config, bms::SocMethod::kCoulomb, start, begin_soc);
    }
  }
};

}  // namespace

SocRecordingResult run_soc_recording(const CellLog& log, const CellParameters& cell, const bms::Config& config,
                                     double otherwise_c) {
  const CellTables tables(cell);
  const auto [hold, hold_from] = hold_of(log, cell, otherwise_c);
  std::vector<double> drawn_ah = charge_drawn_ah(log, hold);
  const std::size_t first = first_row(log), end = end_row(log, drawn_ah, first, cell.capacity_ah);
  const double c = temperature_at(log, first, otherwise_c), a = log.current_a[first];
  const bool rests = std::abs(a) <= kRestShare * cell.capacity_ah;
  SocRecordingResult out;
  out.file = log.path;
  out.remarks = remarks_of(log, first, end, rests, otherwise_c);
  out.remarks.push_back(fmt::format("current {} (from {})", name_of(hold), hold_from));
  if (auto drift = count_drift(log, drawn_ah, tables, {cell.capacity_ah, c, kRestShare * cell.capacity_ah})) {
    out.remarks.push_back(fmt::format("its count drifts by {:+.3f} A: {} rests that end alike say so; taken off",
                                      drift->current_a, drift->rests));
    drawn_ah = std::move(drift->drawn_ah);
  }
  // A discharge test begins rested, and its first row may stand under the current already.
  out.begin_soc = tables.soc_of_ocv(log.voltage_v[first] + a * tables.circuit(1.0, c, std::abs(a)).r0_ohm, c);
  Listeners listeners(config, rests, out.begin_soc);
  double clock_ms = 0.0, volts = log.voltage_v[first];
  bool judged = false;
  for (std::size_t row = first + 1; row < end; ++row) {
    const double dt = log.time_s[row] - log.time_s[row - 1];
    const double before_v = volts;
    if (!std::isnan(log.voltage_v[row])) volts = log.voltage_v[row];
    const double truth = out.begin_soc - (drawn_ah[row] - drawn_ah[first]) / cell.capacity_ah;
    judged = judged || std::abs(truth - out.begin_soc) > kUnjudged;
    const int steps = std::max(1, static_cast<int>(std::ceil(dt / kStep_s)));
    for (int k = 1; k <= steps; ++k) {
      const double share = static_cast<double>(k) / steps;
      clock_ms += 1e3 * dt / steps;
      const Instant now = Instant::from_ms(static_cast<std::uint32_t>(std::llround(std::fmod(clock_ms, 4294967296.0))));
      const double v = hold == CurrentHold::kLinear ? before_v + share * (volts - before_v) : volts;
      for (Fed& each : listeners.fed) {
        each.step(now, held_current(log, row, share, hold), k == steps ? volts : v,
                  temperature_at(log, row, otherwise_c));
      }
    }
    if (!judged) continue;
    out.low_soc = std::min(out.low_soc, truth);
    out.high_soc = std::max(out.high_soc, truth);
    out.judged_s += dt;
    for (Fed& each : listeners.fed) each.judge(truth);
  }
  if (!judged) {
    throw InputError(log.path,
                     end < log.rows() ? "less than a tenth of the charge moves before its first gap"
                                      : "less than a tenth of the charge moves",
                     "a recording in which more does", "Give a discharge or a drive");
  }
  out.slope_bound_points = slope_bound(tables, std::max(0.0, out.low_soc), std::min(1.0, out.high_soc));
  for (std::size_t k = 0; k < listeners.names.size(); ++k) {
    out.rows.push_back({listeners.names[k], listeners.fed[2 * k].score, listeners.fed[2 * k + 1].score});
  }
  return out;
}

}  // namespace voltlap::plant
