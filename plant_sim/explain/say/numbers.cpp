// SPDX-License-Identifier: Apache-2.0
#include "explain/say/numbers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "core/signal.hpp"

namespace voltlap::plant {

int decimals_of(double half) {
  return half > 0.0 ? std::clamp(static_cast<int>(std::ceil(0.6 - std::log10(half))), 0, 5) : 2;
}

std::string channel_words(const std::string& channel) {
  if (channel.starts_with("cell_voltage_")) return "cell " + channel.substr(13);
  if (channel.starts_with("temperature_")) return "thermistor " + channel.substr(12);
  if (channel == "soc") return "SOC";
  std::string words = channel;
  std::replace(words.begin(), words.end(), '_', ' ');
  return words;
}

ShownUnit shown_unit(const std::string& unit, double size) {
  constexpr double kSmall = 0.5;  // V, below it millivolts
  if (unit == "V" && size < kSmall) return {1e3, "mV"};
  return unit == "1" ? ShownUnit{1e2, "%"} : ShownUnit{1.0, unit};
}

std::string gain_text(const Explanation& out) {
  constexpr double kSeen = 0.005;  // less is not seen in three digits
  std::string best;
  double most = 0.0;  // over the noise: all of a millikelvin is less than a part of 20 mV
  for (const auto& [name, gain] : out.gain) {
    if (gain.before <= 0.0 || 1.0 - gain.after / gain.before <= kSeen) continue;
    const double gone =
        std::sqrt(gain.before * gain.before - gain.after * gain.after) / std::max(gain.floor, 1e-12);
    if (gone <= most) continue;
    most = gone;
    const ShownUnit shown = shown_unit(gain.unit, gain.before);
    best = fmt::format("with it, {:.3g} become {:.3g} {} of {} error on blocks that it did not see",
                       shown.scale * gain.before, shown.scale * gain.after, shown.unit, channel_words(name));
  }
  return best;
}

double rms_of(const Eigen::VectorXd& values) {
  return rms(std::span(values.data(), static_cast<std::size_t>(values.size())));
}

const char* name_of(Verdict verdict) {
  constexpr const char* kNames[] = {"named", "ambiguous", "unknown", "no_discrepancy", "bad_data"};
  return kNames[static_cast<std::size_t>(verdict)];
}

}  // namespace voltlap::plant
