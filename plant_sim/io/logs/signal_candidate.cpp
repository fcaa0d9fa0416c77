// SPDX-License-Identifier: Apache-2.0
#include "io/logs/signal_candidate.hpp"

#include <cmath>

#include "core/demand.hpp"
#include "core/signal.hpp"

namespace voltlap::plant {

RoleSource source_in(const RecordedSignal& signal, const std::string& unit) {
  RoleSource out = signal.source;
  const auto named = signal.unit ? signal.unit : unit_named(unit);
  VOLTLAP_DEMAND(named.has_value() || unit.empty());
  if (!named) return out;
  out.unit = named->name;
  out.scale = named->scale;
  out.offset = named->offset;
  return out;
}

SignalCandidate::SignalCandidate(const RecordedSignal& of) : signal(&of), name(spoken_name(of.label)) {
  constexpr double kEnd = 0.02;
  std::vector<double> finite;
  for (const double value : of.value) {
    if (std::isfinite(value)) finite.push_back(value);
  }
  low_ = quantile(finite, kEnd);
  high_ = quantile(finite, 1.0 - kEnd);
  middle_ = median(finite);
}

bool SignalCandidate::is_of(Quantity quantity, Meaning meaning) const {
  return signal->unit ? signal->unit->quantity == quantity : name.meaning == meaning;
}

const char* SignalCandidate::voltage_unit() const {
  constexpr double kMostVolts = 1100.0, kLeastMillivolts = 1500.0, kMostMillivolts = 1.1e6;
  if (signal->unit) return "";
  if (middle_ > kLeastMillivolts && middle_ < kMostMillivolts) return "mV";
  return middle_ >= 1.0 && middle_ < kMostVolts ? "V" : "";
}

double SignalCandidate::volts(double recorded) const {
  const RoleSource source = source_in(*signal, voltage_unit());
  return recorded * source.scale + source.offset;
}

bool SignalCandidate::is_cell_voltage() const {
  const RoleRange range = role_range("cell_voltage_1");
  return volts(low_) >= range.min && volts(high_) <= range.max;
}

bool SignalCandidate::is_called_temperature() const {
  const bool by_unit = signal->unit && signal->unit->quantity == Quantity::kTemperature &&
                       (name.meaning == Meaning::kTime || name.meaning == Meaning::kNothing);
  return by_unit || (is_of(Quantity::kTemperature, Meaning::kTemperature) && name.meaning == Meaning::kTemperature);
}

bool SignalCandidate::is_temperature() const {
  constexpr double kWarm = 60.0, kKelvinLow = 233.0, kKelvinHigh = 353.0;
  if (!is_called_temperature()) return false;
  if (!signal->unit && low_ > kKelvinLow && high_ < kKelvinHigh) return true;  // a reader makes degC of it, and says so
  if (!signal->unit && middle_ > kWarm) return false;  // without a unit what is warmer may be in degF
  const RoleSource source = source_in(*signal, "degC");
  const RoleRange range = role_range("temperature_1");
  return low_ * source.scale + source.offset >= range.min && high_ * source.scale + source.offset <= range.max;
}

bool SignalCandidate::is_called_ambient() const {
  constexpr double kCold = -40.0, kWarm = 60.0;  // degC; what is warmer may be in degF
  return name.owner == Owner::kAmbient && name.meaning == Meaning::kNothing && !signal->unit && low_ >= kCold &&
         high_ <= kWarm;
}

}  // namespace voltlap::plant
