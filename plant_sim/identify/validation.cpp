// SPDX-License-Identifier: Apache-2.0
#include "identify/validation.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "battery/cell_tables.hpp"
#include "core/errors.hpp"
#include "identify/circuit_model.hpp"
#include "identify/rests_and_steps.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLongCharge = 60.0, kLongRest = 60.0;  // s
constexpr double kLookupShare = 0.005;  // of the largest current: smaller ones keep the last lookup current

struct Simulation {
  Eigen::VectorXd voltage, temperature;
};

/// Branches as in circuit_model.hpp, heat as in battery/pack.hpp; the lookup temperature is the recorded one if
/// any.
Simulation simulate_tables(const CellParameters& cell, const CellTables& tables, const TestRun& run,
                           const CellLog& log, double temperature_c) {
  Simulation out{Eigen::VectorXd(run.rows()), Eigen::VectorXd(run.rows())};
  const double floor = kLookupShare * run.current_a.cwiseAbs().maxCoeff();
  const bool measured = !log.temperature_c.empty() && std::isfinite(log.temperature_c.front());
  const double ambient = measured ? log.temperature_c.front() : temperature_c;
  double v1 = 0.0, v2 = 0.0, lookup = 0.0, heat_temperature = ambient;
  CircuitParameters before{};
  for (Index row = 0; row < run.rows(); ++row) {
    const double i = run.current_a(row), dt = run.dt_s(row);
    if (std::abs(i) > floor) lookup = std::abs(i);
    const auto at = static_cast<std::size_t>(row);
    const double t = measured && std::isfinite(log.temperature_c[at]) ? log.temperature_c[at]
                     : measured                                       ? ambient
                                                                      : heat_temperature;
    const CircuitParameters p = tables.circuit(run.soc(row), t, lookup);
    if (run.is_reset(row)) {
      v1 = v2 = 0.0;
    } else if (row > 0) {
      const double begin = run.current_begin_a(row), end = run.current_end_a(row);
      const IntervalResponse a = interval_response(dt, 0.5 * (before.tau1_s + p.tau1_s)),
                             b = interval_response(dt, 0.5 * (before.tau2_s + p.tau2_s));
      v1 = a.a * v1 + a.g0 * before.r1_ohm * begin + a.g1 * p.r1_ohm * end;
      v2 = b.a * v2 + b.g0 * before.r2_ohm * begin + b.g1 * p.r2_ohm * end;
      const double heat = i * i * p.r0_ohm + v1 * v1 / p.r1_ohm + v2 * v2 / p.r2_ohm;
      const double cooling = cell.convection_w_per_m2_k * cell.surface_area_m2,
                   mass = cell.mass_kg * cell.heat_capacity_j_per_kg_k;
      const double target = ambient + (cooling > 0.0 ? heat / cooling : 0.0);
      heat_temperature = target + (heat_temperature - target) * std::exp(-dt * cooling / mass);
    }
    before = p;
    out.voltage(row) = tables.ocv(run.soc(row)).voltage_v - p.r0_ohm * i - v1 - v2;
    out.temperature(row) = heat_temperature;
  }
  return out;
}

/// Rows that count: discharge strokes, without charges of more than a minute and rests of more than a minute.
std::vector<bool> stroke_rows(const TestRun& run, int& strokes) {
  const double quiet = 0.01 * run.current_a.cwiseAbs().maxCoeff();
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
  strokes = 0;
  for (std::size_t row = 0; row < counts.size(); ++row) {
    counts[row] = counts[row] && run.weight_s(static_cast<Index>(row)) > 0.0;
    if (counts[row] && (row == 0 || !counts[row - 1])) ++strokes;
  }
  return counts;
}

struct Scored {
  TestRun run;
  Simulation simulation;
  std::vector<bool> counts;
  int strokes = 0;
  double square = 0.0;
};

double mean_square(const TestRun& run, const Eigen::VectorXd& voltage, const std::vector<bool>& counts) {
  double sum = 0.0, weight = 0.0;
  for (Index row = 0; row < run.rows(); ++row) {
    if (!counts[static_cast<std::size_t>(row)]) continue;
    const double e = voltage(row) - run.voltage_v(row);
    sum += run.weight_s(row) * e * e;
    weight += run.weight_s(row);
  }
  return weight > 0.0 ? sum / weight : 0.0;
}

SocAnchor anchor_of(const CellParameters& cell, const CellTables& tables, const CellLog& log, RunOptions options,
                    const ValidationOptions& given, std::vector<std::size_t>& full) {
  full = full_charges(log);
  // A recording from the bench of the same cell: full is where the cell's own OCV says so.
  std::erase_if(full, [&](std::size_t row) { return log.voltage_v[row] < cell.voltage_max_v - 0.1; });
  if (!full.empty()) return {full.front(), 1.0, "full charge"};
  options.anchor = {0, 0.5, "fitted"};
  const TestRun run = make_run(log, options);
  const auto rests = ocv_from_rests(run);
  if (!rests.empty()) return {0, 0.5 + tables.soc_of_ocv(rests.front().voltage_v) - rests.front().soc, "rest"};
  double best = 1e300, centre = 0.5;
  for (double width = 0.5; width > 5e-4; width *= 0.25) {
    const double from = centre;
    for (int k = -4; k <= 4; ++k) {
      options.anchor.soc = from + width * k / 4.0;
      const TestRun tried = make_run(log, options);
      int strokes = 0;
      const double square =
          mean_square(tried, simulate_tables(cell, tables, tried, log, given.temperature_c).voltage,
                      stroke_rows(tried, strokes));
      if (square < best) {
        best = square;
        centre = options.anchor.soc;
      }
    }
  }
  return {0, centre, "fitted"};
}

Scored score(const CellParameters& cell, const CellTables& tables, const CellLog& log, const RunOptions& options,
             double temperature_c) {
  Scored out{make_run(log, options), {}, {}};
  out.simulation = simulate_tables(cell, tables, out.run, log, temperature_c);
  out.counts = stroke_rows(out.run, out.strokes);
  out.square = mean_square(out.run, out.simulation.voltage, out.counts);
  return out;
}

/// First-order lag of the recorded voltage behind the current: the one that lowers the error most, if by a
/// twentieth.
void find_lag(const Scored& scored, FileValidation& out) {
  constexpr std::array kLags{0.02, 0.04, 0.06, 0.08, 0.1, 0.15, 0.2, 0.3, 0.5, 1.0};
  constexpr double kWorth = 0.95;
  out.rms_v_with_lag = out.rms_v;
  for (const double lag : kLags) {
    Eigen::VectorXd shown = scored.simulation.voltage;
    for (Index row = 1; row < shown.size(); ++row) {
      if (!scored.run.is_reset(row))
        shown(row) += (shown(row - 1) - shown(row)) * std::exp(-scored.run.dt_s(row) / lag);
    }
    const double rms = std::sqrt(mean_square(scored.run, shown, scored.counts));
    if (rms < kWorth * out.rms_v && rms < out.rms_v_with_lag) {
      out.rms_v_with_lag = rms;
      out.voltage_lag_s = lag;
    }
  }
}

void fill_errors(const Scored& scored, FileValidation& out) {
  double weight = 0.0, bias = 0.0, above = 0.0, above_weight = 0.0;
  for (Index row = 0; row < scored.run.rows(); ++row) {
    if (!scored.counts[static_cast<std::size_t>(row)]) continue;
    const double e = scored.simulation.voltage(row) - scored.run.voltage_v(row), w = scored.run.weight_s(row);
    weight += w;
    bias += w * e;
    out.max_error_v = std::max(out.max_error_v, std::abs(e));
    out.ah +=
        0.5 * (scored.run.current_begin_a(row) + scored.run.current_end_a(row)) * scored.run.dt_s(row) / 3600.0;
    if (scored.run.soc(row) > 0.1) {
      above += w * e * e;
      above_weight += w;
    }
  }
  out.rms_v = std::sqrt(scored.square);
  out.bias_v = weight > 0.0 ? bias / weight : 0.0;
  out.rms_v_above_10_soc = above_weight > 0.0 ? std::sqrt(above / above_weight) : 0.0;
  out.strokes = scored.strokes;
}

}  // namespace

FileValidation validate(const CellParameters& cell, const CellLog& log, const ValidationOptions& options) {
  const CellTables tables(cell);
  FileValidation out;
  out.file = log.path;
  out.repairs = log.repairs;
  std::vector<CurrentHold> candidates{CurrentHold::kNext, CurrentHold::kPrevious, CurrentHold::kLinear};
  out.hold_from = "its voltage";
  if (const auto counted = hold_from_counter(log); !counted.empty()) {
    candidates = {counted[0].hold};
    out.hold_from = "its counter";
  }
  Scored best;
  best.square = 1e300;
  for (const CurrentHold hold : candidates) {
    RunOptions run;
    run.hold = hold;
    run.capacity_ah = cell.capacity_ah;
    run.anchor = anchor_of(cell, tables, log, run, options, run.full_rows);
    Scored one = score(cell, tables, log, run, options.temperature_c);
    if (!(one.square < best.square)) continue;
    best = std::move(one);
    out.hold = hold;
    out.soc_start_from = run.anchor.from;
  }
  if (best.strokes == 0) {
    throw InputError(log.path, "no discharge stroke", "current drawn from the cell",
                     "Check the sign of the current in the role map");
  }
  const auto first = std::find(best.counts.begin(), best.counts.end(), true) - best.counts.begin();
  out.soc_start = best.run.soc(std::max<Index>(first - 1, 0));
  fill_errors(best, out);
  find_lag(best, out);
  if (!log.temperature_c.empty()) {
    double sum = 0.0, weight = 0.0;
    for (Index row = 0; row < best.run.rows(); ++row) {
      const double t = log.temperature_c[static_cast<std::size_t>(row)];
      if (!std::isfinite(t)) continue;
      sum +=
          best.run.weight_s(row) * (t - best.simulation.temperature(row)) * (t - best.simulation.temperature(row));
      weight += best.run.weight_s(row);
    }
    if (weight > 0.0) out.temperature_rms_c = std::sqrt(sum / weight);
  }
  return out;
}

}  // namespace voltlap::plant
