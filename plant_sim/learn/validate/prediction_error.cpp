// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/prediction_error.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/demand.hpp"
#include "core/errors.hpp"
#include "core/signal.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLongCharge = 60.0, kLongRest = 60.0;  // s

double charge_as(const MeasuredRun& run, std::size_t first, std::size_t last) {
  double out = 0.0;
  for (std::size_t k = first; k < last; ++k) {
    const auto row = static_cast<Index>(k);
    out += 0.5 * (run.current_begin_a(row) + run.current_end_a(row)) * run.dt_s(row);
  }
  return out;
}

/// A stroke begins and ends with current drawn: what is left of a rest or a charge at its ends does not count, nor does
/// one that draws next to nothing: noise of the sensor within a rest.
void trim_strokes(const MeasuredRun& run, double quiet, std::vector<bool>& counts, int& strokes) {
  constexpr double kTrifle = 1e-4;  // of the charge that is drawn in all of the recording
  const double drawn_as = run.current_a.cwiseMax(0.0).dot(run.dt_s);
  strokes = 0;
  for (std::size_t row = 0; row < counts.size();) {
    std::size_t end = row;
    while (end < counts.size() && counts[end]) ++end;
    const auto drawn = [&](std::size_t at) { return run.current_a(static_cast<Index>(at)) > quiet; };
    std::size_t first = row, last = end;
    while (first < end && !drawn(first)) counts[first++] = false;
    while (last > first && !drawn(last - 1)) counts[--last] = false;
    if (first < last && charge_as(run, first, last) > kTrifle * drawn_as) {
      ++strokes;
    } else {
      for (std::size_t k = first; k < last; ++k) counts[k] = false;
    }
    row = end + 1;
  }
}

/// Rows that count: discharge strokes, without charges of more than a minute and rests of more than a minute.
std::vector<bool> stroke_rows(const MeasuredRun& run, int& strokes) {
  const double quiet = quiet_current(run);
  std::vector<bool> counts(static_cast<std::size_t>(run.rows()), true);
  const auto leave_out = [&](double longest, auto is_part) {
    for (Index row = 0; row < run.rows();) {
      if (!is_part(run.current_a(row))) {
        ++row;
        continue;
      }
      const Index first = row;
      while (row < run.rows() && is_part(run.current_a(row))) ++row;
      const double seconds = run.time_s(row - 1) - run.time_s(std::max<Index>(first - 1, 0));
      if (seconds <= longest) continue;
      for (Index k = first; k < row; ++k) counts[static_cast<std::size_t>(k)] = false;
    }
  };
  leave_out(kLongCharge, [&](double i) { return i < -quiet; });
  leave_out(kLongRest, [&](double i) { return std::abs(i) <= quiet; });
  for (std::size_t row = 0; row < counts.size(); ++row)
    counts[row] = counts[row] && run.weight_s(static_cast<Index>(row)) > 0.0;
  trim_strokes(run, quiet, counts, strokes);
  return counts;
}

template <class Take>
void for_counted(const MeasuredRun& run, const std::vector<bool>& counts, const Take& take) {
  for (Index row = 0; row < run.rows(); ++row) {
    if (counts[static_cast<std::size_t>(row)]) take(row);
  }
}

ErrorSum sum_of(const MeasuredRun& run, const Eigen::VectorXd& voltage, const std::vector<bool>& counts) {
  VOLTLAP_DEMAND(voltage.size() == run.rows() && counts.size() == static_cast<std::size_t>(run.rows()));
  ErrorSum sum;
  for_counted(run, counts, [&](Index row) {
    const double e = voltage(row) - run.voltage_v(row);
    sum += {run.weight_s(row) * e * e, run.weight_s(row)};
  });
  return sum;
}

/// With the counted rows of the recording as it is placed now.
void settle_rows(PlacedRecording& placed) {
  placed.run = make_run(*placed.log, placed.options);
  placed.counts = stroke_rows(placed.run, placed.strokes);
}

/// SOC of the first row by the rest that tells it best: none where all stand on a plateau, or beyond the ends of the
/// OCV, as a cell does that was emptied under load.
std::optional<double> soc_by_rests(const CellModel& model, const PlacedRecording& trial) {
  constexpr double kModel_v = 3e-3, kCapacity = 0.02, kWidest = 0.03;  // errors of OCV and capacity; of SOC
  std::optional<double> out;
  double least = kWidest;
  for (const OcvKnowledge& rest : ocv_from_rests(trial.run)) {
    const double at_c = std::isfinite(rest.temperature_c) ? rest.temperature_c : trial.temperature.start_c;
    const double soc = model.tables().soc_of_ocv(rest.voltage_v, at_c);
    if (soc <= 0.0 || soc >= 1.0) continue;
    const double slope = std::max(1e-9, model.tables().ocv(soc).slope_v);
    const double drawn = trial.options.anchor.soc - rest.soc;
    const double sigma = std::hypot(std::hypot(rest.sigma_v, kModel_v) / slope, kCapacity * drawn);
    if (sigma >= least) continue;
    least = sigma;
    out = soc + drawn;
  }
  return out;
}

SocAnchor anchor_of(const CellModel& model, PlacedRecording& trial) {
  const CellLog& log = *trial.log;
  std::vector<std::size_t>& full = trial.options.full_rows;
  full = full_charges(log);
  // A recording from the bench of the same cell: full is where the cell's own OCV says so, by more than a hysteresis,
  // which lifts a half empty iron phosphate cell to where the curve of a full one begins.
  constexpr double kFull = 0.92, kHysteresis_v = 0.04;  // from one side of it to the other
  std::erase_if(full, [&](std::size_t row) {
    return model.tables().soc_of_ocv(log.voltage_v[row] - kHysteresis_v, trial.temperature.start_c) < kFull;
  });
  if (!full.empty()) return {full.front(), 1.0, "full charge"};
  trial.options.anchor = {0, 0.5, "fitted"};
  settle_rows(trial);
  if (const std::optional<double> start = soc_by_rests(model, trial)) return {0, *start, "rest"};
  double best = 1e300, centre = 0.5;
  for (double width = 0.5; width > 5e-4; width *= 0.25) {
    const double from = centre;
    for (int k = -4; k <= 4; ++k) {
      trial.options.anchor.soc = from + width * k / 4.0;
      settle_rows(trial);
      const double rms = error_of(model, trial).rms_v();
      if (rms < best) {
        best = rms;
        centre = trial.options.anchor.soc;
      }
    }
  }
  return {0, centre, "fitted"};
}

/// First-order lag of the recorded voltage behind the current: the one that lowers the error most, if by a
/// twentieth. One that is shorter than the time between rows may as well be a fast branch that the cell file lacks.
void find_lag(const PlacedRecording& placed, const CellResponse& response, FileValidation& out) {
  constexpr std::array kLags{0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0};
  constexpr double kWorth = 0.95, kOfInterval = 0.9;
  out.rms_v_with_lag = out.rms_v;
  std::vector<double> intervals;
  for_counted(placed.run, placed.counts, [&](Index row) { intervals.push_back(placed.run.dt_s(row)); });
  const double interval = intervals.empty() ? 0.0 : median(std::move(intervals));
  for (const double lag : kLags) {
    if (lag < kOfInterval * interval) continue;
    Eigen::VectorXd shown = response.voltage;
    for (Index row = 1; row < shown.size(); ++row) {
      if (!placed.run.is_reset(row))
        shown(row) += (shown(row - 1) - shown(row)) * std::exp(-placed.run.dt_s(row) / lag);
    }
    const double rms = sum_of(placed.run, shown, placed.counts).rms_v();
    if (rms < kWorth * out.rms_v && rms < out.rms_v_with_lag) {
      out.rms_v_with_lag = rms;
      out.voltage_lag_s = lag;
    }
  }
}

void fill_errors(const PlacedRecording& placed, const CellResponse& response, FileValidation& out) {
  const MeasuredRun& run = placed.run;
  double bias = 0.0;
  ErrorSum above;
  for_counted(run, placed.counts, [&](Index row) {
    const double e = response.voltage(row) - run.voltage_v(row), w = run.weight_s(row);
    const ErrorSum one{w * e * e, w};
    out.error += one;
    bias += w * e;
    out.max_error_v = std::max(out.max_error_v, std::abs(e));
    out.ah += 0.5 * (run.current_begin_a(row) + run.current_end_a(row)) * run.dt_s(row) / 3600.0;
    if (run.soc(row) > 0.1) above += one;
    for (SocBand& band : out.bands) {
      if (run.soc(row) > band.low && run.soc(row) <= band.high) band.error += one;
    }
  });
  out.rms_v = out.error.rms_v();
  out.bias_v = out.error.weight_s > 0.0 ? bias / out.error.weight_s : 0.0;
  out.rms_v_above_10_soc = above.rms_v();
}

std::optional<double> temperature_rms(const PlacedRecording& placed, const CellResponse& response) {
  if (placed.temperature.cell_c.empty()) return std::nullopt;
  ErrorSum sum;
  for (Index row = 0; row < placed.run.rows(); ++row) {
    // By its own time: a row whose voltage is none has no weight but may have a temperature.
    const double e = placed.temperature.cell_c[static_cast<std::size_t>(row)] - response.temperature(row),
                 w = placed.run.is_reset(row) ? 0.0 : std::min(placed.run.dt_s(row), placed.options.weight_cap_s);
    if (std::isfinite(e)) sum += {w * e * e, w};
  }
  return sum.weight_s > 0.0 ? std::optional(sum.rms_v()) : std::nullopt;
}

/// One current: all but a tenth of the drawn rows within a third of each other, as a resistor's is.
bool draws_one_current(const PlacedRecording& placed) {
  constexpr double kDrawn = 0.05, kBand = 0.35;
  std::vector<double> drawn;
  const double most = placed.run.current_a.maxCoeff();
  for_counted(placed.run, placed.counts, [&](Index row) {
    if (placed.run.current_a(row) > kDrawn * most) drawn.push_back(placed.run.current_a(row));
  });
  if (drawn.empty()) return false;
  return quantile(drawn, 0.95) - quantile(drawn, 0.05) < kBand * median(drawn);
}

TemperatureKind temperature_kind(const PlacedRecording& placed) {
  constexpr double kHeld = 4.0;  // K from lowest to highest; reference study, 2016, section 5.5: within +- 2
  if (placed.temperature.cell_c.empty()) return TemperatureKind::kNotRecorded;
  double low = 1e9, high = -1e9;
  for_counted(placed.run, placed.counts, [&](Index row) {
    const double t = placed.temperature.cell_c[static_cast<std::size_t>(row)];
    if (!std::isfinite(t)) return;
    low = std::min(low, t);
    high = std::max(high, t);
  });
  return high - low > kHeld ? TemperatureKind::kFree : TemperatureKind::kHeld;
}

double soc_at_start(const PlacedRecording& placed) {
  const auto first = std::find(placed.counts.begin(), placed.counts.end(), true) - placed.counts.begin();
  return placed.run.soc(std::max<Index>(first - 1, 0));
}

}  // namespace

PlacedRecording place_recording(const CellModel& model, const CellLog& log, const ValidationOptions& options) {
  VOLTLAP_DEMAND(log.rows() > 0 && model.cell().capacity_ah > 0.0);
  std::vector<CurrentHold> candidates{CurrentHold::kNext, CurrentHold::kPrevious, CurrentHold::kLinear};
  std::string hold_from = "its voltage";
  if (const auto counted = hold_from_counter(log); !counted.empty()) {
    candidates = {counted[0].hold};
    hold_from = "its counter";
  }
  std::optional<PlacedRecording> best;
  double least = 1e300;
  for (const CurrentHold hold : candidates) {
    PlacedRecording trial{&log, {}, hold_from, {log, options.temperature_c, options.temperature_told}, {}, {}, 0};
    trial.options.hold = hold;
    trial.options.capacity_ah = model.cell().capacity_ah;
    trial.options.anchor = anchor_of(model, trial);
    settle_rows(trial);
    const double rms = error_of(model, trial).rms_v();
    if (best && !(rms < least)) continue;
    least = rms;
    best = std::move(trial);
  }
  if (best->strokes == 0) {
    throw InputError(log.path, "no discharge stroke", "current drawn from the cell",
                     "Check the sign of the current in the role map");
  }
  return std::move(*best);
}

MeasuredRun changed_run(const PlacedRecording& placed, const RunChange& change) {
  VOLTLAP_DEMAND(placed.log != nullptr && change.capacity_ah >= 0.0);
  RunOptions options = placed.options;
  if (change.capacity_ah > 0.0) options.capacity_ah = change.capacity_ah;
  MeasuredRun run = make_run(*placed.log, options);
  run.soc.array() += change.soc_share * soc_at_start(placed);
  return run;
}

ErrorSum error_of(const CellModel& model, const PlacedRecording& placed, const RunChange& change) {
  const bool as_placed = change.capacity_ah == 0.0 && change.soc_share == 0.0;
  if (as_placed) return sum_of(placed.run, respond(model, placed.run, placed.temperature).voltage, placed.counts);
  const MeasuredRun run = changed_run(placed, change);
  return sum_of(run, respond(model, run, placed.temperature).voltage, placed.counts);
}

CapacityAdjustment adjust_capacity(const CellModel& model, const PlacedRecording& placed) {
  constexpr double kReach = 0.15, kFinest = 5e-5;
  const double nominal = placed.options.capacity_ah;
  VOLTLAP_DEMAND(nominal > 0.0);
  const auto rms_at = [&](double share) { return error_of(model, placed, {nominal * (1.0 + share), 0.0}).rms_v(); };
  double centre = 0.0, best = error_of(model, placed).rms_v();
  for (double step = 0.05; step > kFinest; step *= 1.0 / 3.0) {
    const double from = centre;
    for (int k = -3; k <= 3; ++k) {
      const double share = from + step * k;
      if (k == 0 || std::abs(share) > kReach + 1e-9) continue;
      const double rms = rms_at(share);
      if (rms >= best) continue;
      best = rms;
      centre = share;
    }
  }
  return {nominal * centre, best, std::abs(centre) > kReach - 10.0 * kFinest};
}

FileValidation validate(const CellModel& model, const PlacedRecording& placed, const CellResponse& response) {
  VOLTLAP_DEMAND(placed.log != nullptr && response.voltage.size() == placed.run.rows());
  FileValidation out;
  out.file = placed.log->path;
  out.repairs = placed.log->repairs;
  out.hold = placed.options.hold;
  out.hold_from = placed.hold_from;
  out.strokes = placed.strokes;
  out.soc_start = soc_at_start(placed);
  out.soc_start_from = placed.options.anchor.from;
  out.constant_current = draws_one_current(placed);
  out.temperature = temperature_kind(placed);
  fill_errors(placed, response, out);
  find_lag(placed, response, out);
  out.temperature_rms_c = temperature_rms(placed, response);
  out.simulated = {placed.temperature.start_c, response.temperature.maxCoeff(), placed.temperature.start_from};
  out.capacity = adjust_capacity(model, placed);
  return out;
}

FileValidation validate(const CellParameters& cell, const CellLog& log, const ValidationOptions& options) {
  const CellModel model(cell);
  const PlacedRecording placed = place_recording(model, log, options);
  return validate(model, placed, respond(model, placed.run, placed.temperature));
}

}  // namespace voltlap::plant
