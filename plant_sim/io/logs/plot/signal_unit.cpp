// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/signal_unit.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <string_view>

namespace voltlap::plant {
namespace {

struct KnownUnit {
  std::string_view text, quantity;
  std::string_view spellings;  ///< between bars, in small letters without blanks
};

constexpr std::array kKnown{
    KnownUnit{"V", "Voltage", "|v|volt|volts|vdc|"},
    KnownUnit{"mV", "Voltage", "|mv|millivolt|millivolts|"},
    KnownUnit{"A", "Current", "|a|amp|amps|ampere|amperes|adc|"},
    KnownUnit{"mA", "Current", "|ma|milliamp|milliamps|"},
    KnownUnit{"rpm", "Rotation", "|rpm|1/min|min-1|u/min|"},
    KnownUnit{"Nm", "Torque", "|nm|n.m|n·m|n-m|n*m|newtonmeter|"},
    KnownUnit{"km/h", "Speed", "|km/h|kmh|kph|kmph|km/hr|"},
    KnownUnit{"m/s", "Speed", "|m/s|mps|"},
    KnownUnit{"mph", "Speed", "|mph|mi/h|"},
    KnownUnit{"kW", "Power", "|kw|kilowatt|"},
    KnownUnit{"W", "Power", "|w|watt|watts|"},
    KnownUnit{"%", "Share", "|%|percent|pct|per|percentage|"},
    KnownUnit{"°C", "Temperature", "|degc|c|°c|ºc|celsius|degreesc|degreec|degcelsius|degrees_c|deg_c|"},
    KnownUnit{"°F", "Temperature", "|degf|f|°f|fahrenheit|"},
    KnownUnit{"bar", "Pressure", "|bar|"},
    KnownUnit{"kPa", "Pressure", "|kpa|"},
    KnownUnit{"psi", "Pressure", "|psi|"},
    KnownUnit{"°", "Angle", "|deg|degree|degrees|°|º|"},
    KnownUnit{"°/s", "Rate of turn", "|deg/s|°/s|deg/sec|degree/s|dps|"},
    KnownUnit{"g", "Acceleration", "|g|"},
    KnownUnit{"m/s²", "Acceleration", "|m/s^2|m/s2|m/s²|"},
    KnownUnit{"Ah", "Charge", "|ah|amphours|amp-hours|"},
    KnownUnit{"kWh", "Energy", "|kwh|"},
    KnownUnit{"Wh", "Energy", "|wh|"},
    KnownUnit{"mΩ", "Resistance", "|mohm|mohms|milliohm|milliohms|mω|"},
    KnownUnit{"Ω", "Resistance", "|ohm|ohms|ω|"},
    KnownUnit{"kΩ", "Resistance", "|kohm|kohms|"},
    KnownUnit{"m", "Distance", "|m|meter|meters|"},
    KnownUnit{"km", "Distance", "|km|"},
    KnownUnit{"Hz", "Frequency", "|hz|"},
    KnownUnit{"s", "Time", "|s|sec|secs|second|seconds|"},
    KnownUnit{"ms", "Time", "|ms|msec|millisecond|milliseconds|"},
    KnownUnit{"", "Numbers without a unit",
              "||1|-|bool|boolean|none|enum|flag|bit|bits|n/a|na|unitless|count|counts|hex|"},
};

/// Some files put the quantity before it: "current:A", "temperature:C".
std::string_view without_quantity(std::string_view spelled) {
  const std::size_t colon = spelled.rfind(':');
  return colon == std::string_view::npos ? spelled : spelled.substr(colon + 1);
}

}  // namespace

SignalUnit signal_unit(const std::string& spelled) {
  const std::string_view text = without_quantity(spelled);
  std::string key = "|";
  for (const char c : text) {
    if (c != ' ') key += static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  }
  key += '|';
  const auto* at = std::find_if(kKnown.begin(), kKnown.end(), [&](const KnownUnit& known) {
    return known.spellings.find(key) != std::string_view::npos;
  });
  if (at == kKnown.end()) return {std::string(text), {}, kKnown.size()};
  return {std::string(at->text), std::string(at->quantity), static_cast<std::size_t>(at - kKnown.begin())};
}

}  // namespace voltlap::plant
