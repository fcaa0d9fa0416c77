// SPDX-License-Identifier: Apache-2.0
#include "apps/soc_recording.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include <fmt/format.h>

#include "apps/count_drift.hpp"
#include "bms/estimate/soc_record.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
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

/// From where the charge is counted.
struct Begin {
  std::size_t row = 0;
  double volts = 0.0;
  bool rests = false;
  double rest_s = 0.0;   ///< how long it rests before the current begins
  double moved_v = 0.0;  ///< in the last minute of that rest
};

/// The last minute before the current begins: a recorder's first rows may be its own, and a cell relaxes. Without a
/// rest the first row with a voltage.
Begin begin_of(const CellLog& log, double rest_a) {
  constexpr double kLast_s = 60.0;
  std::size_t first = 0;
  while (first < log.rows() && std::isnan(log.voltage_v[first])) ++first;
  if (first == log.rows()) {
    throw InputError(log.path, "no voltage", "one: the truth is counted from it",
                     "Give a recording of current and voltage");
  }
  std::size_t on = first;
  while (on < log.rows() && std::abs(log.current_a[on]) <= rest_a && !(on > first && log.gap[on])) ++on;
  if (on == first) return {first, log.voltage_v[first]};
  Begin out{first, 0.0, true, log.time_s[on - 1] - log.time_s[first]};
  while (log.time_s[on - 1] - log.time_s[out.row] > kLast_s) ++out.row;
  std::vector<double> volts;
  for (std::size_t row = out.row; row < on; ++row) {
    if (std::isfinite(log.voltage_v[row])) volts.push_back(log.voltage_v[row]);
  }
  if (volts.empty()) return {first, log.voltage_v[first], true, out.rest_s};
  const std::size_t half = (volts.size() + 1) / 2;
  out.volts = median({volts.end() - static_cast<std::ptrdiff_t>(half), volts.end()});
  out.moved_v = out.volts - median({volts.begin(), volts.begin() + static_cast<std::ptrdiff_t>(half)});
  return out;
}

/// A rest at a voltage that the cell of the file cannot have is another cell's, or another count of cells.
void require_possible_rest(const CellLog& log, const CellTables& tables, double volts, double c) {
  constexpr double kBeyond_v = 0.05;
  const double full = tables.ocv_v(1.0, c), empty = tables.ocv_v(0.0, c);
  if (volts <= full + kBeyond_v && volts >= empty - kBeyond_v) return;
  throw InputError(log.path, fmt::format("{:.3f} V a cell at rest", volts),
                   fmt::format("{:.3f} (empty) to {:.3f} V (full) by the cell file", empty, full),
                   "Correct --cells-in-series, or give the file of this cell");
}

void require_possible_charge(const CellLog& log, const SocRecordingResult& out, double capacity_ah) {
  constexpr double kBeyond = 0.1;
  if (out.low_soc >= -kBeyond && out.high_soc <= 1.0 + kBeyond) return;
  throw InputError(log.path,
                   fmt::format("a charge that counts from {:.0f} % to between {:.0f} and {:.0f} % of {:.4g} Ah",
                               100.0 * out.begin_soc, 100.0 * out.low_soc, 100.0 * out.high_soc, capacity_ah),
                   "0 to 100 %",
                   "Check the current's sign and unit (--map), --cells-in-parallel, and whose the cell file is");
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

/// What a reader must know of the rows from `begin` to `end`.
std::vector<std::string> remarks_of(const CellLog& log, const Begin& begin, std::size_t end, double otherwise_c) {
  constexpr double kShort_s = 60.0, kMoves_v = 0.002;
  std::vector<std::string> out = log.repairs;
  if (!begin.rests)
    out.push_back(fmt::format("begins under {:.4g} A: taken as rested before", log.current_a[begin.row]));
  if (begin.rests && begin.rest_s < kShort_s)
    out.push_back(fmt::format("begins with a rest of {:.0f} s: taken as rested before", begin.rest_s));
  if (std::abs(begin.moved_v) > kMoves_v)
    out.push_back(fmt::format("its voltage still moves by {:.0f} mV in the last minute before the current begins",
                              1e3 * begin.moved_v));
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
  const double rest_a = kRestShare * cell.capacity_ah;
  const Begin begin = begin_of(log, rest_a);
  const std::size_t first = begin.row, end = end_row(log, drawn_ah, first, cell.capacity_ah);
  const double c = temperature_at(log, first, otherwise_c), a = begin.rests ? 0.0 : log.current_a[first];
  SocRecordingResult out;
  out.file = log.path;
  out.remarks = remarks_of(log, begin, end, otherwise_c);
  out.remarks.push_back(fmt::format("current {} (from {})", name_of(hold), hold_from));
  if (auto drift = count_drift(log, drawn_ah, tables, {cell.capacity_ah, c, rest_a})) {
    out.remarks.push_back(fmt::format("its count drifts by {:+.3f} A: {} rests that end alike say so; taken off",
                                      drift->current_a, drift->rests));
    drawn_ah = std::move(drift->drawn_ah);
  }
  if (begin.rests) require_possible_rest(log, tables, begin.volts, c);
  // A discharge test begins rested, and its first row may stand under the current already.
  out.begin_soc = tables.soc_of_ocv(begin.volts + a * tables.circuit(1.0, c, std::abs(a)).r0_ohm, c);
  Listeners listeners(config, begin.rests, out.begin_soc);
  double clock_ms = 0.0, volts = begin.volts;
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
                     fmt::format("less than a tenth of {:.4g} Ah moves in {:.4g} s{}", cell.capacity_ah,
                                 log.time_s[end - 1] - log.time_s[first], end < log.rows() ? ", to its first gap" : ""),
                     "a recording in which more does",
                     "Give a discharge or a drive; if it is one, check the unit of its time and current (--map)");
  }
  require_possible_charge(log, out, cell.capacity_ah);
  out.slope_bound_points = slope_bound(tables, std::max(0.0, out.low_soc), std::min(1.0, out.high_soc));
  for (std::size_t k = 0; k < listeners.names.size(); ++k) {
    out.rows.push_back({listeners.names[k], listeners.fed[2 * k].score, listeners.fed[2 * k + 1].score});
  }
  return out;
}

}  // namespace voltlap::plant
