// SPDX-License-Identifier: Apache-2.0
#include "replay/bus_as_pack.hpp"

#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "core/signal.hpp"

namespace voltlap::plant {
namespace {

/// For each sample of the bus: whether it is the pack, from the end of the precharge until the contactors open.
std::vector<bool> connected_samples(const Channel& bus) {
  constexpr double kUsual = 0.75, kCharged = 0.97, kOpened = 0.75;  // quantile; of it
  std::vector<double> values;
  for (const double value : bus.value) {
    if (std::isfinite(value)) values.push_back(value);
  }
  const double usual = values.empty() ? std::numeric_limits<double>::quiet_NaN() : quantile(std::move(values), kUsual);
  std::vector<bool> out;
  bool connected = false;
  for (const double value : bus.value) {
    if (std::isfinite(value)) connected = value > (connected ? kOpened : kCharged) * usual;
    out.push_back(connected);
  }
  return out;
}

}  // namespace

Channel pack_by_bus(const Channel& bus, const Channel* published) {
  const std::vector<bool> connected = connected_samples(bus);
  std::vector<std::pair<double, double>> samples;
  std::size_t next = 0;
  const std::size_t count = published == nullptr ? 0 : published->size();
  for (std::size_t k = 0; k < bus.size(); ++k) {
    const bool before = k > 0 && connected[k - 1];
    for (; next < count && published->time_s[next] < bus.time_s[k]; ++next) {
      if (!before && !connected[k]) samples.emplace_back(published->time_s[next], published->value[next]);
    }
    if (connected[k]) samples.emplace_back(bus.time_s[k], bus.value[k]);
  }
  Channel out;
  out.role = "pack_voltage";
  for (const auto& [time_s, value] : samples) {
    out.time_s.push_back(time_s);
    out.value.push_back(value);
  }
  return out;
}

}  // namespace voltlap::plant
