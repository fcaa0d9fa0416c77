// SPDX-License-Identifier: Apache-2.0
#include "replay/soc_start.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace voltlap::plant {
namespace {

constexpr double kStep_s = 1e-3 * can::kTickMs;
constexpr double kRelaxed_s = 60.0;      // chosen: most of a cell's slow branch
constexpr double kLongestGap_s = 2.0;    // without a current, in all; more is no count
constexpr double kReading_v = 5e-3;      // what a resting cell may be off by
constexpr double kTells = 0.05;          // of charge; a curve where kReading_v is more says less than the log's own SOC

/// The point of a curve at `x`, straight between its points and beyond them not at all.
template <class X, class Y>
double along(const std::vector<std::pair<double, double>>& curve, double at, X x, Y y) {
  for (std::size_t k = 1; k < curve.size(); ++k) {
    if (at > x(curve[k]) && k + 1 < curve.size()) continue;
    const double share = (at - x(curve[k - 1])) / (x(curve[k]) - x(curve[k - 1]));
    return y(curve[k - 1]) + std::clamp(share, 0.0, 1.0) * (y(curve[k]) - y(curve[k - 1]));
  }
  return kUnknown;
}

constexpr auto kFirst = [](const std::pair<double, double>& point) { return point.first; };
constexpr auto kSecond = [](const std::pair<double, double>& point) { return point.second; };

/// Mean over the cells of the SOC that belongs to their voltage and `raised_v`.
double mean_soc(const DriveLog& log, const ReplayCar& car, double time_s, double raised_v) {
  double sum = 0.0, count = 0.0;
  const auto add = [&](double volts) {
    if (!std::isfinite(volts)) return;
    sum += soc_of_ocv(car, volts + raised_v);
    count += 1.0;
  };
  for (const auto& [n, channel] : log.numbered("cell_voltage_")) add(value_at(*channel, time_s));
  if (const Channel* voltage = log.find("voltage"); count == 0.0 && voltage != nullptr) add(value_at(*voltage, time_s));
  for (const char* role : {"pack_voltage", "bus_voltage"}) {
    const Channel* pack = log.find(role);
    if (count == 0.0 && pack != nullptr) add(value_at(*pack, time_s) / static_cast<double>(car.cells));
  }
  return count > 0.0 ? sum / count : kUnknown;
}

struct Rest {
  double end_s = 0.0, length_s = 0.0, charge_ah = 0.0;  // what flowed between the begin of the recording and there
};

/// Of a minute or more, at its end: the longer it is the more the cells have relaxed.
std::optional<Rest> first_rest(const DriveLog& log, const ReplayCar& car, double begin_s) {
  const Channel* recorded = log.find("current");
  HeldChannel current(recorded, std::max(0.5, 5.0 * usual_interval_s({recorded})));
  double charge_as = 0.0, rest_s = 0.0, gap_s = 0.0;
  std::optional<Rest> out;
  for (double t = begin_s; t <= current.last_s() && gap_s <= kLongestGap_s; t += kStep_s) {
    current.advance(t);
    if (!current.known()) {
      gap_s += kStep_s;
      continue;
    }
    charge_as += current.value() * kStep_s;
    rest_s = std::abs(current.value()) <= car.rest_current_a ? rest_s + kStep_s : 0.0;
    if (out && rest_s == 0.0) break;
    if (rest_s >= kRelaxed_s) out = Rest{t, rest_s, charge_as / 3600.0};
  }
  return out;
}

std::optional<SocStart> counted_back(const DriveLog& log, const ReplayCar& car, double begin_s, bool other_is_known) {
  const std::optional<Rest> rest = first_rest(log, car, begin_s);
  if (!rest) return std::nullopt;
  const double there = mean_soc(log, car, rest->end_s, 0.0), raised = mean_soc(log, car, rest->end_s, kReading_v);
  if (!std::isfinite(there) || (other_is_known && raised - there > kTells)) return std::nullopt;
  const double soc = std::clamp(there + rest->charge_ah / car.capacity_ah, 0.0, 1.0);
  return SocStart{soc, SocSource::kCountedBack,
                  fmt::format("no rest at the begin: the SOC starts at {:.1f} %, counted back from a rest of {:.0f} s "
                              "that ends at {:.1f} s, {:.1f} % by the open-circuit voltage (5 mV there are {:.1f} "
                              "points), {:.3f} Ah earlier",
                              100.0 * soc, rest->length_s, rest->end_s, 100.0 * there, 100.0 * (raised - there),
                              rest->charge_ah)};
}

SocStart unloaded(const DriveLog& log, const ReplayCar& car, double begin_s, bool soc_jumps) {
  const double current_a = value_at(*log.find("current"), begin_s);
  const double soc = mean_soc(log, car, begin_s, current_a * car.resistance_ohm);
  return {soc, SocSource::kUnloaded,
          fmt::format("no rest of a minute in the log and {}: it starts at {:.1f} %, from cells under {:.0f} A and the "
                      "{:.2f} mOhm of the pack file, wrong by what that resistance is and by what is slower",
                      soc_jumps ? "its own SOC jumps" : "no SOC of its own", 100.0 * soc, current_a,
                      1e3 * car.resistance_ohm)};
}

}  // namespace

double ocv_of_soc(const ReplayCar& car, double soc) { return along(car.ocv, soc, kFirst, kSecond); }

double soc_of_ocv(const ReplayCar& car, double voltage_v) { return along(car.ocv, voltage_v, kSecond, kFirst); }

SocStart soc_under_load(const DriveLog& log, const ReplayCar& car, double begin_s, bool soc_jumps) {
  const Channel* own = log.find("soc");
  const double logged = own == nullptr || soc_jumps ? kUnknown : value_at(*own, begin_s);
  if (const auto out = counted_back(log, car, begin_s, std::isfinite(logged))) return *out;
  if (!std::isfinite(logged)) return unloaded(log, car, begin_s, soc_jumps);
  return {std::clamp(logged, 0.0, 1.0), SocSource::kLogged,
          fmt::format("no rest that tells the charge: the SOC starts at the log's own {:.1f} %; only what it moves by "
                      "is the firmware's",
                      100.0 * logged)};
}

}  // namespace voltlap::plant
