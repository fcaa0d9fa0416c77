// SPDX-License-Identifier: Apache-2.0
#include "apps/limit_test_report.hpp"

#include <algorithm>
#include <cmath>
#include <span>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace voltlap::plant {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* kMethodNames[] = {"equation", "table", "ahead"};
const char* name_of(bms::LimitMethod method) { return kMethodNames[static_cast<std::size_t>(method)]; }
const char* mark_text(bool is_met) { return is_met ? "met" : "NOT MET"; }

struct Method {
  const char* name;
  LimitTrial LimitMoment::*trial;
};
constexpr Method kMethods[] = {
    {"ahead", &LimitMoment::ahead}, {"equation", &LimitMoment::equation}, {"table", &LimitMoment::table}};

/// Where the cells ended that a limit was set by.
struct Ends {
  std::vector<double> inside_v;  // sorted
  [[nodiscard]] double at(double share) const {
    return inside_v[static_cast<std::size_t>(share * static_cast<double>(inside_v.size() - 1))];
  }
  [[nodiscard]] double share_beyond() const {
    const auto beyond = std::count_if(inside_v.begin(), inside_v.end(), [](double v) { return v < -kMarkBeyond_v; });
    return static_cast<double>(beyond) / static_cast<double>(inside_v.size());
  }
  [[nodiscard]] double share_far_inside() const {
    const auto far = std::count_if(inside_v.begin(), inside_v.end(), [](double v) { return v > kMarkInside_v; });
    return static_cast<double>(far) / static_cast<double>(inside_v.size());
  }
};

/// A limit of almost nothing is an empty or a full pack: what it holds is not its own doing.
constexpr double kNothing_a = 1.0;

Ends ends_of(const std::vector<LimitMoment>& moments, bool discharge, std::size_t horizon, const Method& method) {
  Ends out;
  for (const LimitMoment& m : moments) {
    const LimitTrial& trial = m.*method.trial;
    if (m.discharge != discharge || m.horizon != horizon || !trial.by_voltage || trial.limit_a < kNothing_a) continue;
    out.inside_v.push_back(trial.inside_v);
  }
  std::sort(out.inside_v.begin(), out.inside_v.end());
  return out;
}

/// Largest share by which the integers are off the bisection, of limits above an ampere.
double worst_of_bisection(const std::vector<LimitMoment>& moments) {
  double worst = 0.0;
  for (const LimitMoment& m : moments) {
    if (m.bisected_a < kNothing_a) continue;
    worst = std::max(worst, std::abs(m.ahead.limit_a - m.bisected_a) / m.bisected_a);
  }
  return worst;
}

std::size_t states_of(const std::vector<LimitMoment>& moments) {
  return moments.size() / (2 * kTriedHorizons);
}

std::string row_text(const char* method, const Ends& ends, bool judged) {
  if (ends.inside_v.empty()) return fmt::format("    {:<10}{:>8}\n", method, 0);
  const bool met = ends.share_beyond() + ends.share_far_inside() <= 1.0 - kMarkShare;
  return fmt::format("    {:<10}{:>8}{:>9.0f}{:>8.0f}{:>8.0f}{:>10.1f}{:>10.1f}   {}\n", method, ends.inside_v.size(),
                     1e3 * ends.at(0.01), 1e3 * ends.at(0.5), 1e3 * ends.at(0.99), 100.0 * ends.share_beyond(),
                     100.0 * ends.share_far_inside(), judged ? mark_text(met) : "");
}

std::string moments_text(const LimitTestResult& result) {
  const double worst = worst_of_bisection(result.moments);
  std::string out = fmt::format(
      "{} states of drawn drives (seed {}), each limit applied to the plant for its time\n"
      "  integers beside a bisection in double precision: {:.2f} % at most, mark {:.1f} %, {}\n\n",
      states_of(result.moments), result.seed, 100.0 * worst, 100.0 * kMarkBisection,
      mark_text(worst <= kMarkBisection));
  out += fmt::format("  where a voltage sets it   cells end inside the bound, mV     more than, % of them\n"
                     "    {:<10}{:>8}{:>9}{:>8}{:>8}{:>10}{:>10}\n",
                     "limit", "states", "1 %", "half", "99 %", fmt::format("-{:.0f} mV", 1e3 * kMarkBeyond_v),
                     fmt::format("+{:.0f} mV", 1e3 * kMarkInside_v));
  for (const bool discharge : {true, false}) {
    for (std::size_t h = 0; h < kTriedHorizons; ++h) {
      out += fmt::format("  {}, {:g} s\n", discharge ? "discharge" : "charge", 1e-3 * bms::kLimitHorizons[h].ms());
      for (const Method& method : kMethods) {
        const bool judged = method.trial == &LimitMoment::ahead;
        out += row_text(method.name, ends_of(result.moments, discharge, h, method), judged);
      }
    }
  }
  return out + "\n";
}

/// The same drive under the equation; nullptr when there is none that came home.
const LimitRaceRow* beside(std::span<const LimitRaceRow> rows, const LimitRaceRow& row) {
  for (const LimitRaceRow& other : rows) {
    const bool same = other.car == row.car && other.temperature_c == row.temperature_c &&
                      other.resistance == row.resistance;
    if (same && other.method == bms::LimitMethod::kEquation && other.race.drive.finished) return &other;
  }
  return nullptr;
}

std::string race_text(std::span<const LimitRaceRow> rows, const LimitRaceRow& row) {
  const LimitRaceRow* other = beside(rows, row);
  const bool compared = other != nullptr && row.race.drive.finished;
  const double more_s = compared ? row.race.drive.total_time_s - other->race.drive.total_time_s : 0.0;
  return fmt::format("  {:>6.0f}{:>9.1f}   {:<10}{:>9.1f}{:>11}{:>10.0f}{:>11}{:>11.3f}   {}\n", row.temperature_c,
                     row.resistance, name_of(row.method), row.race.drive.total_time_s,
                     compared ? fmt::format("{:+.1f}", more_s) : "", row.race.bound_s, row.race.reversals,
                     row.race.lowest_cell_v,
                     row.race.drive.finished       ? "finished"
                     : row.race.under_voltage      ? "UNDER-VOLTAGE TRIP"
                                                   : row.race.drive.failure_cause);
}

std::string race_head(const std::string& car) {
  return fmt::format("22 km, {}\n"
                     "  {:>6}{:>9}   {:<10}{:>9}{:>11}{:>10}{:>11}{:>11}\n",
                     car, "degC", "R told", "limit", "time, s", "to eq., s", "bound, s", "reversals", "lowest, V");
}

Json trial_json(const LimitTrial& trial) {
  return {{"limit_a", trial.limit_a}, {"by_voltage", trial.by_voltage}, {"inside_v", trial.inside_v}};
}

Json moment_json(const LimitMoment& m) {
  return {{"drive_seed", m.seed},
          {"time_s", m.time_s},
          {"soc", m.soc},
          {"temperature_c", m.temperature_c},
          {"direction", m.discharge ? "discharge" : "charge"},
          {"horizon_s", 1e-3 * bms::kLimitHorizons[m.horizon].ms()},
          {"bisected_a", m.bisected_a},
          {"ahead", trial_json(m.ahead)},
          {"equation", trial_json(m.equation)},
          {"table", trial_json(m.table)}};
}

Json race_json(const LimitRaceRow& row) {
  return {{"car", row.car},
          {"temperature_c", row.temperature_c},
          {"resistance", row.resistance},
          {"limit_method", name_of(row.method)},
          {"finished", row.race.drive.finished},
          {"cause", row.race.drive.failure_cause},
          {"under_voltage_trip", row.race.under_voltage},
          {"total_time_s", row.race.drive.total_time_s},
          {"bound_s", row.race.bound_s},
          {"reversals", row.race.reversals},
          {"lowest_cell_v", row.race.lowest_cell_v}};
}

}  // namespace

std::string limit_test_text(const LimitTestResult& result) {
  std::string out = result.moments.empty() ? std::string{} : moments_text(result);
  if (result.races.empty()) return out;
  const std::string* car = nullptr;
  for (const LimitRaceRow& row : result.races) {
    if (car == nullptr || *car != row.car) out += race_head(row.car);
    car = &row.car;
    out += race_text(result.races, row);
  }
  return out;
}

std::string limit_test_json(const LimitTestResult& result) {
  Json moments = Json::array(), races = Json::array();
  for (const LimitMoment& m : result.moments) moments.push_back(moment_json(m));
  for (const LimitRaceRow& row : result.races) races.push_back(race_json(row));
  const Json out = {{"seed", result.seed},
                    {"states", states_of(result.moments)},
                    {"bisection_off_at_most", worst_of_bisection(result.moments)},
                    {"moments", moments},
                    {"races", races}};
  return out.dump(1) + "\n";
}

}  // namespace voltlap::plant
