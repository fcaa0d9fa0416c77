// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/count_hint.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"
#include "learn/identify/preparation/first_estimates.hpp"

namespace voltlap::plant {
namespace {

CellLog first_rows(const CellLog& log) {
  constexpr std::size_t kRows = 5000;
  CellLog out = log;
  if (log.rows() <= kRows) return out;
  for (auto* values :
       {&out.time_s, &out.current_a, &out.voltage_v, &out.temperature_c, &out.ambient_c, &out.charge_ah}) {
    if (!values->empty()) values->resize(kRows);
  }
  out.gap.resize(kRows);
  return out;
}

/// As if the current were `current` times and the voltage `voltage` times as large. Infinite where nothing is drawn.
double rms_scaled(const CellModel& model, CellLog log, const ValidationOptions& options, double current,
                  double voltage) {
  for (double& i : log.current_a) i *= current;
  for (double& q : log.charge_ah) q *= current;
  for (double& v : log.voltage_v) v *= voltage;
  try {
    return error_of(model, place_recording(model, log, options)).rms_v();
  } catch (const InputError&) {
    return 1e300;
  }
}

struct Count {
  int number = 0;
  double rms_v = 1e300;
};

/// Times as much resistance as the recorded current and voltage have, the cell has: about the number in parallel.
double missing_parallel(const CellModel& model, const CellLog& log, const ValidationOptions& options) {
  RunOptions run;
  run.capacity_ah = model.cell().capacity_ah;
  const double recorded = resistance_step_median({make_run(log, run)});
  const double own = model.tables().circuit(0.6, options.temperature_c, 0.0).r0_ohm;
  return recorded > 0.0 ? own / recorded : 1.0;
}

/// The best number from `first` to `last`: in a dozen steps, then one by one around the best of them.
template <class Rms>
Count best_of(double first, double last, int now, const Rms& rms_with) {
  constexpr double kSteps = 12.0;
  Count best;
  const auto look_at = [&](double n) {
    if (n < 1.0 || n == now) return;
    const double rms = rms_with(n);
    if (rms < best.rms_v) best = {static_cast<int>(n), rms};
  };
  const double step = std::max(1.0, std::floor((last - first) / kSteps));
  for (double n = first; n <= last; n += step) look_at(n);
  const double around = best.number;
  for (double n = around - step + 1.0; step > 1.0 && n < around + step; n += 1.0) look_at(n);
  return best;
}

Count best_parallel(const CellModel& model, const CellLog& log, const ValidationOptions& options, int now) {
  constexpr double kMost = 100.0;
  const double about = missing_parallel(model, log, options) * now;
  return best_of(std::max(1.0, std::floor(0.5 * about)), std::min(kMost, std::ceil(1.6 * about)), now,
                 [&](double n) { return rms_scaled(model, log, options, now / n, 1.0); });
}

Count best_series(const CellModel& model, const CellLog& log, const ValidationOptions& options, int now) {
  constexpr double kReach = 0.25;
  return best_of(std::max(1.0, std::floor((1.0 - kReach) * now)), std::ceil((1.0 + kReach) * now), now,
                 [&](double n) { return rms_scaled(model, log, options, 1.0, now / n); });
}

}  // namespace

std::optional<std::string> count_hint(const CellModel& model, const CellLog& log, const ValidationOptions& options,
                                      const CellCounts& counts, double rms_v) {
  constexpr double kEnormous_v = 0.15, kSound_v = 0.1, kFalls = 0.25;
  if (rms_v < kEnormous_v) return std::nullopt;
  const CellLog rows = first_rows(log);
  const Count parallel = best_parallel(model, rows, options, counts.in_parallel);
  const Count series = best_series(model, rows, options, counts.in_series);
  const bool is_parallel = parallel.rms_v <= series.rms_v;
  const Count& best = is_parallel ? parallel : series;
  if (best.rms_v > std::min(kSound_v, kFalls * rms_v)) return std::nullopt;
  const char* flag = is_parallel ? "--cells-in-parallel" : "--cells-in-series";
  return fmt::format("hint: an RMS of {:.0f} mV is not that of this cell; with {} {} it would be {:.0f} mV",
                     1e3 * rms_v, flag, best.number, 1e3 * best.rms_v);
}

}  // namespace voltlap::plant
