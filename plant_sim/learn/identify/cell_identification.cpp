// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/cell_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <future>

#include "core/demand.hpp"
#include "learn/identify/common_time_constants.hpp"
#include "learn/identify/operating_grid.hpp"

namespace voltlap::plant {
namespace {

/// Every place of the grid at which there are recordings.
CellIdentification at_operating_points(std::vector<CellLog> logs, const OperatingGrid& grid) {
  CellIdentification out;
  out.temperatures_c = grid.temperatures_c;
  out.currents_a = grid.currents_a;
  for (std::size_t t = 0; t < grid.temperatures_c.size(); ++t) {
    for (std::size_t i = 0; i < grid.currents_a.size(); ++i) {
      OperatingPoint point{grid.temperatures_c[t], grid.currents_a[i], {}, {}};
      for (std::size_t k = 0; k < logs.size(); ++k) {
        if (grid.temperature_of[k] == t && grid.current_of[k] == i) point.logs.push_back(std::move(logs[k]));
      }
      if (!point.logs.empty()) out.points.push_back(std::move(point));
    }
  }
  return out;
}

std::size_t nearest_to_usual_temperature(const std::vector<OperatingPoint>& points) {
  constexpr double kUsual = 25.0;
  std::size_t nearest = 0;
  for (std::size_t k = 1; k < points.size(); ++k) {
    const auto distance = [&](std::size_t at) { return std::abs(points[at].temperature_c - kUsual); };
    if (distance(k) < distance(nearest)) nearest = k;
  }
  return nearest;
}

/// Recordings of one operating point are at its temperature where they have none of their own.
IdentifyOptions at_temperature(IdentifyOptions options, double temperature_c, std::size_t recordings) {
  options.reference_temperature_c = temperature_c;
  options.temperatures_c.assign(recordings, temperature_c);
  return options;
}

/// All points with the capacity and the number of branches that the reference has: tables of different circuits do not
/// mix.
std::vector<IdentificationProblem> problems_like_reference(const CellIdentification& cell,
                                                           const IdentifyOptions& options) {
  IdentifyOptions like_reference = options;
  like_reference.capacity_ah = cell.reference_point().result.model.capacity_ah;
  like_reference.branches = static_cast<int>(cell.reference_point().result.model.branches());
  like_reference.progress = nullptr;
  std::vector<std::future<IdentificationProblem>> preparing;
  for (const OperatingPoint& point : cell.points) {
    IdentifyOptions own = at_temperature(like_reference, point.temperature_c, point.logs.size());
    if (&point == &cell.reference_point()) own.capacity_ah = options.capacity_ah;
    preparing.push_back(
        std::async(std::launch::async, [&point, own] { return IdentificationProblem(point.logs, own); }));
  }
  std::vector<IdentificationProblem> problems;
  for (auto& one : preparing) problems.push_back(one.get());
  return problems;
}

/// With the time constants of each point; without any, all points but the reference, which stands already.
void fit_points(std::vector<IdentificationProblem> problems, const std::vector<Eigen::VectorXd>& taus_s,
                CellIdentification& cell) {
  VOLTLAP_DEMAND(problems.size() == cell.points.size());
  VOLTLAP_DEMAND(taus_s.empty() || taus_s.size() == cell.points.size());
  std::vector<std::future<void>> running;
  for (std::size_t k = 0; k < cell.points.size(); ++k) {
    if (taus_s.empty() && k == cell.reference) continue;
    running.push_back(std::async(std::launch::async, [&, k] {
      std::optional<Eigen::VectorXd> centre;
      if (!taus_s.empty()) centre = taus_s[k];
      cell.points[k].result = std::move(problems[k]).fit(centre);
    }));
  }
  for (auto& one : running) one.get();
}

/// How many branches there are was found before, from the reference alone; it is told with the rest.
void keep_choices(IdentifyResult alone, IdentifyResult& result) {
  result.orders = std::move(alone.orders);
  for (const std::string& note : alone.notes) {
    if (std::find(result.notes.begin(), result.notes.end(), note) == result.notes.end()) result.notes.push_back(note);
  }
}

std::string time_constants_note(const Eigen::VectorXd& taus_s, const CellIdentification& cell) {
  std::vector<std::string> seconds;
  for (const double tau : taus_s) seconds.push_back(fmt::format("{:.3g}", tau));
  return fmt::format("Time constants around {} s at {:.0f} degC, looked for in all {} tests together.",
                     fmt::join(seconds, " and "), cell.reference_point().temperature_c, cell.points.size());
}

/// All points anew, around time constants that they have together.
void fit_together(std::vector<IdentificationProblem> problems, CellIdentification& cell) {
  std::vector<double> temperatures_c;
  for (const OperatingPoint& point : cell.points) temperatures_c.push_back(point.temperature_c);
  const auto branches = static_cast<int>(cell.reference_point().result.model.branches());
  const std::vector<Eigen::VectorXd> taus_s = common_time_constants(problems, temperatures_c, branches);
  IdentifyResult alone = cell.reference_point().result;
  fit_points(std::move(problems), taus_s, cell);
  IdentifyResult& result = cell.reference_point().result;
  keep_choices(std::move(alone), result);
  result.notes.push_back(time_constants_note(taus_s[cell.reference], cell));
}

}  // namespace

const OperatingPoint& CellIdentification::at(std::size_t temperature, std::size_t current) const {
  VOLTLAP_DEMAND(!points.empty() && temperature < temperatures_c.size() && current < currents_a.size());
  const OperatingPoint* best = &points.front();
  double least = 1e300;
  for (const OperatingPoint& point : points) {
    const double dt = (point.temperature_c - temperatures_c[temperature]) / 10.0;
    const double di = std::log((point.current_a + 1.0) / (currents_a[current] + 1.0));
    // A neighbour in current is nearer than one in temperature: tables change little with current.
    const double distance = std::abs(dt) + 0.01 * std::abs(di);
    if (distance < least) {
      least = distance;
      best = &point;
    }
  }
  return *best;
}

bool CellIdentification::was_tested(std::size_t temperature, std::size_t current) const {
  const OperatingPoint& point = at(temperature, current);
  return std::abs(point.temperature_c - temperatures_c[temperature]) < 1e-9 &&
         std::abs(point.current_a - currents_a[current]) < 1e-9;
}

namespace {

/// Each operating point by itself: as many tables as there are tests.
CellIdentification identify_by_point(CellIdentification cell, const IdentifyOptions& options) {
  OperatingPoint& reference = cell.reference_point();
  reference.result = identify(reference.logs, at_temperature(options, reference.temperature_c, reference.logs.size()));
  if (cell.points.size() == 1) return cell;
  std::vector<IdentificationProblem> problems = problems_like_reference(cell, options);
  if (options.method) {
    fit_points(std::move(problems), {}, cell);
  } else {
    if (options.progress) options.progress("time constants of all tests together");
    fit_together(std::move(problems), cell);
  }
  return cell;
}

/// All recordings together: one table over SOC, and laws over temperature and current.
CellIdentification identify_by_laws(const std::vector<CellLog>& logs, const std::vector<double>& temperatures_c,
                                    const CellIdentification& by_point, const IdentifyOptions& options) {
  const OperatingPoint& reference = by_point.reference_point();
  CellIdentification out;
  const double current_a = by_point.currents_a.size() > 1 ? 0.0 : by_point.currents_a.front();
  out.points.push_back({reference.temperature_c, current_a, logs, {}});
  out.temperatures_c = {reference.temperature_c};
  out.currents_a = {current_a};
  out.temperature_told = options.temperature_told;
  IdentifyOptions together = at_temperature(options, reference.temperature_c, logs.size());
  together.temperatures_c = temperatures_c;
  out.points[0].result = identify(logs, together);
  return out;
}

}  // namespace

CellIdentification identify_cell(std::vector<CellLog> logs, const std::vector<double>& temperatures_c,
                                 const IdentifyOptions& options) {
  const OperatingGrid grid = operating_grid(logs, temperatures_c);
  const std::vector<CellLog> all = logs;
  CellIdentification cell = at_operating_points(std::move(logs), grid);
  cell.reference = nearest_to_usual_temperature(cell.points);
  cell.temperature_told = options.temperature_told;
  if (options.method) return identify_by_point(std::move(cell), options);
  const bool by_test = options.tables == IdentifyOptions::Tables::kByTest && !options.constant;
  if (cell.points.size() == 1 || !by_test) return identify_by_laws(all, temperatures_c, cell, options);
  return identify_by_point(std::move(cell), options);
}

}  // namespace voltlap::plant
