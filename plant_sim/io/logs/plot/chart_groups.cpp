// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/chart_groups.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "core/demand.hpp"
#include "io/logs/plot/signal_choice.hpp"

namespace voltlap::plant {
namespace {

constexpr std::size_t kMostInChart = 6;  // colours that are told apart
constexpr double kOfOneSize = 6.0;       // largest of a chart over its smallest

std::string quantity_of(const std::string& unit) {
  static const std::map<std::string, std::string> kQuantities = {
      {"V", "Voltage"},     {"mV", "Voltage"},      {"A", "Current"},      {"mA", "Current"},   {"°C", "Temperature"},
      {"K", "Temperature"}, {"rpm", "Rotation"},    {"Nm", "Torque"},      {"km/h", "Speed"},   {"m/s", "Speed"},
      {"mph", "Speed"},     {"kW", "Power"},        {"W", "Power"},        {"%", "Share"},      {"bar", "Pressure"},
      {"kPa", "Pressure"},  {"psi", "Pressure"},    {"kWh", "Energy"},     {"Wh", "Energy"},    {"Ah", "Charge"},
      {"s", "Time"},        {"ms", "Time"},         {"Hz", "Frequency"},   {"m", "Distance"},   {"km", "Distance"},
      {"g", "Acceleration"}, {"m/s^2", "Acceleration"}, {"Ω", "Resistance"}, {"mΩ", "Resistance"}, {"mohm", "Resistance"},
      {"°", "Angle"},       {"kOhm", "Resistance"}, {"kohm", "Resistance"}};
  const auto at = kQuantities.find(unit);
  if (at != kQuantities.end()) return at->second;
  return unit.empty() ? "Numbers without a unit" : "In " + unit;
}

double size_of(const SignalSurvey& survey) { return std::max(std::abs(survey.low()), std::abs(survey.high())); }

/// What is left of the last signal's name when a chart has one alone.
std::string title_of(const ChartGroup& group, bool alone_of_unit, const std::vector<SignalHead>& heads,
                     const std::vector<SignalSurvey>& surveys) {
  if (group.signals.size() == 1) return heads[group.signals.front()].name;
  const std::string quantity = quantity_of(group.unit);
  if (alone_of_unit) return quantity;
  double low = surveys[group.signals.front()].low(), high = surveys[group.signals.front()].high();
  for (const std::size_t k : group.signals) {
    low = std::min(low, surveys[k].low());
    high = std::max(high, surveys[k].high());
  }
  return fmt::format("{}, {:.4g} to {:.4g}{}", quantity, low, high, group.unit.empty() ? "" : " " + group.unit);
}

}  // namespace

std::vector<ChartGroup> chart_groups(const std::vector<std::size_t>& chosen, const std::vector<SignalHead>& heads,
                                     const std::vector<SignalSurvey>& surveys) {
  VOLTLAP_DEMAND(surveys.size() == heads.size());
  std::map<std::string, std::vector<std::size_t>> by_unit;
  for (const std::size_t k : chosen) by_unit[unit_text(heads[k].unit)].push_back(k);
  std::vector<ChartGroup> out;
  for (auto& [unit, signals] : by_unit) {
    std::stable_sort(signals.begin(), signals.end(),
                     [&](std::size_t a, std::size_t b) { return size_of(surveys[a]) > size_of(surveys[b]); });
    const std::size_t first = out.size();
    double largest = 0.0;
    for (const std::size_t k : signals) {
      const double size = size_of(surveys[k]);
      if (out.size() == first || out.back().signals.size() == kMostInChart || size * kOfOneSize < largest) {
        out.push_back({{}, unit, {}, 0});
        largest = size;
      }
      out.back().signals.push_back(k);
      out.back().decimals = std::max(out.back().decimals, surveys[k].decimals());
    }
    for (std::size_t g = first; g < out.size(); ++g)
      out[g].title = title_of(out[g], out.size() == first + 1, heads, surveys);
  }
  // Where no signal has a unit comes last: states and flags.
  std::stable_partition(out.begin(), out.end(), [](const ChartGroup& group) { return !group.unit.empty(); });
  for (ChartGroup& group : out) std::sort(group.signals.begin(), group.signals.end());
  return out;
}

}  // namespace voltlap::plant
