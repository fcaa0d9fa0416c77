// SPDX-License-Identifier: Apache-2.0
#include "learn/validate/thermal_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "car/battery/cell_thermal.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLeastRise = 1.0;                   // K; below it a heat capacity is noise
constexpr double kRateLow = 1e-6, kRateHigh = 3e-2;  // 1/s of G / C: 12 days to half a minute
constexpr double kLongestLag = 600.0;                // s

/// What the temperature is not linear in.
struct Pace {
  double rate = 0.0, lag_s = 0.0;  ///< G / C [1/s], of the surface [s]
};

/// Rows of T = x0 / C + own start: what the linear part is solved from.
struct LinearPart {
  Eigen::MatrixXd columns;
  Eigen::VectorXd rest, weight;
};

/// One quantity within the cell, and at its surface.
struct Lagging {
  double cell, surface;
  void set(double value) { cell = surface = value; }
  void go(double value, double lag_s, double dt_s) {
    surface = surface_after(surface, cell, value, lag_s, dt_s);
    cell = value;
  }
};

/// Columns: 1/C, start of each recording.
LinearPart linear_part(const std::vector<ThermalRecording>& recordings, const Pace& pace) {
  const double rate = pace.rate, lag = pace.lag_s;
  VOLTLAP_DEMAND(rate > 0.0 && lag >= 0.0);
  Index rows = 0;
  for (const auto& r : recordings) {
    rows +=
        std::count_if(r.temperature_c.begin(), r.temperature_c.end(), [](double t) { return std::isfinite(t); });
  }
  LinearPart out{Eigen::MatrixXd::Zero(rows, 1 + static_cast<Index>(recordings.size())),
                 Eigen::VectorXd::Zero(rows), Eigen::VectorXd::Zero(rows)};
  Index at = 0;
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const ThermalRecording& r = recordings[k];
    Lagging by_heat{0.0, 0.0}, known{0.0, 0.0}, by_start{1.0, 1.0};
    for (std::size_t row = 0; row < r.temperature_c.size(); ++row) {
      const double dt = r.dt_s[row];
      if (row > 0 && dt <= 0.0) {
        // Nothing is known of what happened before: it goes on from what is recorded there.
        by_heat.set(0.0);
        by_start.set(0.0);
        known.set(std::isfinite(r.temperature_c[row]) ? r.temperature_c[row] : known.surface);
      } else if (row > 0) {
        const double stay = std::exp(-rate * dt), mean = (1.0 - stay) / rate;
        by_heat.go(stay * by_heat.cell + mean * r.heat_w[row], lag, dt);
        by_start.go(by_start.cell * stay, lag, dt);
        known.go(stay * known.cell + (1.0 - stay) * r.ambient_c[row - 1], lag, dt);
      }
      if (!std::isfinite(r.temperature_c[row])) continue;
      const double weight =
          std::sqrt(std::max(0.0, 0.5 * (dt + (row + 1 < r.dt_s.size() ? r.dt_s[row + 1] : 0.0))));
      out.columns(at, 0) = weight * by_heat.surface;
      out.columns(at, 1 + static_cast<Index>(k)) = weight * by_start.surface;
      out.rest(at) = weight * (r.temperature_c[row] - known.surface);
      out.weight(at++) = weight;
    }
  }
  return out;
}

struct Solved {
  double cost = 1e300;
  Eigen::VectorXd x, residual;
};

Solved solve(const std::vector<ThermalRecording>& recordings, const Pace& pace) {
  const LinearPart part = linear_part(recordings, pace);
  Solved out;
  out.x = part.columns.colPivHouseholderQr().solve(part.rest);
  out.residual = part.rest - part.columns * out.x;
  out.cost = out.residual.squaredNorm();
  if (!(out.x(0) > 0.0)) out.cost = 1e300;
  return out;
}

double best_rate(const std::vector<ThermalRecording>& recordings) {
  double centre = 0.0, best = 1e300;
  const auto look = [&](double log_rate) {
    if (log_rate < std::log(kRateLow) || log_rate > std::log(kRateHigh)) return;
    const double cost = solve(recordings, {std::exp(log_rate), 0.0}).cost;
    if (cost >= best) return;
    best = cost;
    centre = log_rate;
  };
  for (int k = 0; k <= 40; ++k) look(std::log(kRateLow) + k / 40.0 * std::log(kRateHigh / kRateLow));
  for (double step = 0.13; step > 1e-6; step *= 0.5) {
    const double from = centre;
    look(from - step);
    look(from + step);
  }
  return std::exp(centre);
}

/// Beginning at a rate without a lag.
Pace best_pace(const std::vector<ThermalRecording>& recordings, double rate) {
  Pace out{rate, 0.0};
  double best = solve(recordings, out).cost;
  const auto look = [&](const Pace& pace) {
    if (pace.lag_s < 0.0 || pace.lag_s > kLongestLag || pace.rate < kRateLow || pace.rate > kRateHigh) return false;
    const double cost = solve(recordings, pace).cost;
    if (cost >= best) return false;
    best = cost;
    out = pace;
    return true;
  };
  double step_s = 64.0, step = 0.2;
  while (step_s > 0.02) {
    const Pace from = out;
    const bool better = look({from.rate, from.lag_s + step_s}) || look({from.rate, from.lag_s - step_s}) ||
                        look({from.rate * std::exp(step), from.lag_s}) ||
                        look({from.rate * std::exp(-step), from.lag_s}) ||
                        look({from.rate * std::exp(step), from.lag_s + step_s}) ||
                        look({from.rate * std::exp(-step), std::max(0.0, from.lag_s - step_s)});
    if (better) continue;
    step_s *= 0.5;
    step *= 0.5;
  }
  return out;
}

/// 95 % half widths of C and G, relative, and of the lag. Neighbouring residuals resemble each other: with correlation
/// r from row to row only (1 - r) / (1 + r) of the rows count.
void widths(const std::vector<ThermalRecording>& recordings, const Pace& pace, bool with_lag, ThermalModel& model) {
  constexpr double kStep = 1e-4, kStep_s = 0.05;
  const Solved here = solve(recordings, pace);
  const LinearPart part = linear_part(recordings, pace);
  const Index linear = part.columns.cols();
  Eigen::MatrixXd jacobian(part.columns.rows(), linear + (with_lag ? 2 : 1));
  jacobian.leftCols(linear) = part.columns;
  const auto slope = [&](const Pace& next_pace, double step) -> Eigen::VectorXd {
    const LinearPart next = linear_part(recordings, next_pace);
    return ((next.columns * here.x - next.rest) - (part.columns * here.x - part.rest)) / step;
  };
  jacobian.col(linear) = slope({pace.rate * (1.0 + kStep), pace.lag_s}, kStep);
  if (with_lag) jacobian.col(linear + 1) = slope({pace.rate, pace.lag_s + kStep_s}, kStep_s);
  double with = 0.0;
  for (Index row = 1; row < here.residual.size(); ++row) with += here.residual(row) * here.residual(row - 1);
  const double r = std::clamp(with / here.cost, 0.0, 0.999);
  const double freedom = std::max(1.0, static_cast<double>(jacobian.rows() - jacobian.cols()));
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse() * (here.cost / freedom * (1.0 + r) / (1.0 - r));
  // ln C = -ln x0, ln G = ln a - ln x0
  const double of_c = covariance(0, 0) / (here.x(0) * here.x(0)), of_a = covariance(linear, linear),
               both = covariance(0, linear) / here.x(0);
  model.capacity_ci95 = 1.96 * std::sqrt(of_c);
  model.conductance_ci95 = 1.96 * std::sqrt(std::max(0.0, of_c + of_a - 2.0 * both));
  if (with_lag) model.surface_lag_ci95_s = 1.96 * std::sqrt(covariance(linear + 1, linear + 1));
}

ThermalRecording part_of(const ThermalRecording& whole, std::size_t first, std::size_t last) {
  const auto cut = [&](const std::vector<double>& values) {
    if (values.empty()) return values;
    return std::vector<double>(values.begin() + static_cast<std::ptrdiff_t>(first),
                               values.begin() + static_cast<std::ptrdiff_t>(last));
  };
  return {whole.file,           cut(whole.dt_s),      cut(whole.heat_w), cut(whole.temperature_c),
          cut(whole.ambient_c), whole.ambient_assumed};
}

std::optional<ThermalModel> fit_if_told(const std::vector<ThermalRecording>& recordings) {
  try {
    return fit_thermal(recordings);
  } catch (const InputError&) {
    return std::nullopt;
  }
}

}  // namespace

ThermalRecording thermal_recording(const std::string& file, const MeasuredRun& run, const CellResponse& response,
                                   const RecordedTemperature& temperature) {
  VOLTLAP_DEMAND(response.heat_w.size() == run.rows());
  VOLTLAP_DEMAND(temperature.cell_c.size() == static_cast<std::size_t>(run.rows()));
  ThermalRecording out{file, {}, {}, temperature.cell_c, temperature.ambient_c, temperature.ambient_c.empty()};
  if (out.ambient_assumed) out.ambient_c.assign(out.temperature_c.size(), temperature.start_c);
  for (Index row = 0; row < run.rows(); ++row) {
    out.dt_s.push_back(run.is_reset(row) ? 0.0 : run.dt_s(row));
    out.heat_w.push_back(response.heat_w(row));
  }
  double last = temperature.start_c;
  for (double& ambient : out.ambient_c) last = ambient = std::isfinite(ambient) ? ambient : last;
  return out;
}

ThermalModel fit_thermal(const std::vector<ThermalRecording>& recordings) {
  double rise = 0.0;
  for (const ThermalRecording& r : recordings) {
    double low = 1e9, high = -1e9;
    for (const double t : r.temperature_c) {
      if (!std::isfinite(t)) continue;
      low = std::min(low, t);
      high = std::max(high, t);
    }
    rise = std::max(rise, high - low);
  }
  if (rise < kLeastRise) {
    throw InputError(
        recordings.empty() ? "thermal model" : recordings.front().file,
        recordings.empty() ? "no recorded temperature" : fmt::format("temperatures within {:.2g} K", rise),
        fmt::format("temperatures that change by {} K or more", kLeastRise),
        "Give a recording in which the cell warms itself, with a temperature column");
  }
  const double rate = best_rate(recordings);
  if (!(solve(recordings, {rate, 0.0}).cost < 1e300)) {
    throw InputError(recordings.front().file, "a cell that cools under load",
                     "a temperature that rises with the heat",
                     "Check the temperature's column and the sign of the current");
  }
  const auto model_at = [&](const Pace& pace, bool with_lag) {
    ThermalModel model;
    model.capacity_j_per_k = 1.0 / solve(recordings, pace).x(0);
    model.conductance_w_per_k = pace.rate * model.capacity_j_per_k;
    model.surface_lag_s = pace.lag_s;
    widths(recordings, pace, with_lag, model);
    return model;
  };
  const ThermalModel model = model_at(best_pace(recordings, rate), true);
  return model.surface_lag_s > model.surface_lag_ci95_s ? model : model_at({rate, 0.0}, false);
}

std::vector<double> thermal_response(const ThermalModel& model, const ThermalRecording& recording) {
  VOLTLAP_DEMAND(model.capacity_j_per_k > 0.0 && recording.dt_s.size() == recording.temperature_c.size());
  const CellThermal thermal{model.capacity_j_per_k, model.conductance_w_per_k, model.surface_lag_s};
  const auto known = std::find_if(recording.temperature_c.begin(), recording.temperature_c.end(),
                                  [](double t) { return std::isfinite(t); });
  double t = known == recording.temperature_c.end() ? 25.0 : *known;
  double surface = t;
  std::vector<double> out{t};
  for (std::size_t row = 1; row < recording.temperature_c.size(); ++row) {
    const double dt = recording.dt_s[row], before = t;
    if (dt <= 0.0) {
      if (std::isfinite(recording.temperature_c[row])) t = surface = recording.temperature_c[row];
    } else {
      t = temperature_after(thermal, t, recording.heat_w[row], recording.ambient_c[row - 1], dt, thermal.decay(dt));
    }
    if (dt > 0.0) surface = surface_after(surface, before, t, model.surface_lag_s, dt);
    out.push_back(surface);
  }
  return out;
}

double thermal_rms_c(const ThermalModel& model, const ThermalRecording& recording, std::size_t from_row) {
  const std::vector<double> t = thermal_response(model, recording);
  VOLTLAP_DEMAND(t.size() == recording.dt_s.size());
  double sum = 0.0, weight = 0.0;
  for (std::size_t row = from_row; row < t.size(); ++row) {
    const double e = t[row] - recording.temperature_c[row], dt = recording.dt_s[row];
    if (!std::isfinite(e)) continue;
    sum += dt * e * e;
    weight += dt;
  }
  return weight > 0.0 ? std::sqrt(sum / weight) : 0.0;
}

ThermalValidation validate_thermal(const CellParameters& cell, const std::vector<ThermalRecording>& recordings) {
  ThermalValidation out{fit_thermal(recordings), {}};
  const ThermalModel given{cell.mass_kg * cell.heat_capacity_j_per_kg_k,
                           cell.convection_w_per_m2_k * cell.surface_area_m2, 0.0, 0.0, cell.surface_lag_s, 0.0};
  for (std::size_t k = 0; k < recordings.size(); ++k) {
    const ThermalRecording& one = recordings[k];
    ThermalValidation::File file{one.file, thermal_rms_c(given, one), thermal_rms_c(out.fitted, one),
                                 one.ambient_assumed, std::nullopt};
    std::vector<ThermalRecording> others = recordings;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(k));
    const std::size_t half = one.dt_s.size() / 2;
    if (others.empty()) others.push_back(part_of(one, 0, half));
    if (const auto model = fit_if_told(others)) {
      file.rms_held_out_c = thermal_rms_c(*model, one, recordings.size() == 1 ? half : 0);
    }
    out.files.push_back(file);
  }
  return out;
}

}  // namespace voltlap::plant
