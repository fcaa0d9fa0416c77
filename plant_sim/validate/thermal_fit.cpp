// SPDX-License-Identifier: Apache-2.0
#include "validate/thermal_fit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

using Eigen::Index;

constexpr double kLeastRise = 1.0;                   // K; below it a heat capacity is noise
constexpr double kRateLow = 1e-6, kRateHigh = 3e-2;  // 1/s of G / C: 12 days to half a minute

/// Rows of T = x0 / C + own start: what the linear part is solved from.
struct LinearPart {
  Eigen::MatrixXd columns;
  Eigen::VectorXd rest, weight;
};

/// Columns: 1/C, start of each recording.
LinearPart linear_part(const std::vector<ThermalRecording>& recordings, double rate) {
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
    double by_heat = 0.0, known = 0.0, by_start = 1.0;
    for (std::size_t row = 0; row < r.temperature_c.size(); ++row) {
      const double dt = r.dt_s[row];
      if (row > 0 && dt <= 0.0) {
        // Nothing is known of what happened before: it goes on from what is recorded there.
        by_heat = by_start = 0.0;
        known = std::isfinite(r.temperature_c[row]) ? r.temperature_c[row] : known;
      } else if (row > 0) {
        const double stay = std::exp(-rate * dt), mean = (1.0 - stay) / rate;
        by_heat = stay * by_heat + mean * r.heat_w[row];
        by_start *= stay;
        known = stay * known + (1.0 - stay) * r.ambient_c[row - 1];
      }
      if (!std::isfinite(r.temperature_c[row])) continue;
      const double weight =
          std::sqrt(std::max(0.0, 0.5 * (dt + (row + 1 < r.dt_s.size() ? r.dt_s[row + 1] : 0.0))));
      out.columns(at, 0) = weight * by_heat;
      out.columns(at, 1 + static_cast<Index>(k)) = weight * by_start;
      out.rest(at) = weight * (r.temperature_c[row] - known);
      out.weight(at++) = weight;
    }
  }
  return out;
}

struct Solved {
  double cost = 1e300;
  Eigen::VectorXd x, residual;
};

Solved solve(const std::vector<ThermalRecording>& recordings, double rate) {
  const LinearPart part = linear_part(recordings, rate);
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
    const double cost = solve(recordings, std::exp(log_rate)).cost;
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

/// Relative 95 % half widths of C and G. Neighbouring residuals resemble each other: with correlation r from row to
/// row only (1 - r) / (1 + r) of the rows count.
void widths(const std::vector<ThermalRecording>& recordings, double rate, ThermalModel& model) {
  constexpr double kStep = 1e-4;
  const Solved here = solve(recordings, rate);
  const LinearPart part = linear_part(recordings, rate), next = linear_part(recordings, rate * (1.0 + kStep));
  Eigen::MatrixXd jacobian(part.columns.rows(), part.columns.cols() + 1);
  jacobian.leftCols(part.columns.cols()) = part.columns;
  jacobian.rightCols(1) = ((next.columns * here.x - next.rest) - (part.columns * here.x - part.rest)) / kStep;
  double with = 0.0;
  for (Index row = 1; row < here.residual.size(); ++row) with += here.residual(row) * here.residual(row - 1);
  const double r = std::clamp(with / here.cost, 0.0, 0.999);
  const double freedom = std::max(1.0, static_cast<double>(jacobian.rows() - jacobian.cols()));
  const Eigen::MatrixXd covariance =
      (jacobian.transpose() * jacobian).inverse() * (here.cost / freedom * (1.0 + r) / (1.0 - r));
  // ln C = -ln x0, ln G = ln a - ln x0
  const Index last = jacobian.cols() - 1;
  const double of_c = covariance(0, 0) / (here.x(0) * here.x(0)), of_a = covariance(last, last),
               both = covariance(0, last) / here.x(0);
  model.capacity_ci95 = 1.96 * std::sqrt(of_c);
  model.conductance_ci95 = 1.96 * std::sqrt(std::max(0.0, of_c + of_a - 2.0 * both));
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

ThermalRecording thermal_recording(const std::string& file, const TestRun& run, const CellResponse& response,
                                   const RecordedTemperature& temperature) {
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
  const Solved solved = solve(recordings, rate);
  if (!(solved.cost < 1e300)) {
    throw InputError(recordings.front().file, "a cell that cools under load",
                     "a temperature that rises with the heat",
                     "Check the temperature's column and the sign of the current");
  }
  ThermalModel model;
  model.capacity_j_per_k = 1.0 / solved.x(0);
  model.conductance_w_per_k = rate * model.capacity_j_per_k;
  widths(recordings, rate, model);
  return model;
}

std::vector<double> thermal_response(const ThermalModel& model, const ThermalRecording& recording) {
  const double rate = model.conductance_w_per_k / model.capacity_j_per_k;
  const auto known = std::find_if(recording.temperature_c.begin(), recording.temperature_c.end(),
                                  [](double t) { return std::isfinite(t); });
  double t = known == recording.temperature_c.end() ? 25.0 : *known;
  std::vector<double> out{t};
  for (std::size_t row = 1; row < recording.temperature_c.size(); ++row) {
    const double dt = recording.dt_s[row];
    if (dt <= 0.0) {
      if (std::isfinite(recording.temperature_c[row])) t = recording.temperature_c[row];
    } else if (rate > 0.0) {
      const double target = recording.ambient_c[row - 1] + recording.heat_w[row] / model.conductance_w_per_k;
      t = target + (t - target) * std::exp(-rate * dt);
    } else {
      t += recording.heat_w[row] * dt / model.capacity_j_per_k;
    }
    out.push_back(t);
  }
  return out;
}

double thermal_rms_c(const ThermalModel& model, const ThermalRecording& recording, std::size_t from_row) {
  const std::vector<double> t = thermal_response(model, recording);
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
                           cell.convection_w_per_m2_k * cell.surface_area_m2, 0.0, 0.0};
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
