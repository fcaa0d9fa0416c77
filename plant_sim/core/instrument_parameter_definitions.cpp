// SPDX-License-Identifier: Apache-2.0
// sensors.<instrument>.*: the same six keys for every instrument, so the rows are made, not written.
#include <deque>
#include <limits>
#include <string>

#include <fmt/format.h>

#include "core/parameter_rows.hpp"

namespace voltlap::plant {
namespace {

using S = SensorSection;
constexpr double kAny = std::numeric_limits<double>::infinity();
constexpr double kDelayMax_s = 10.0, kLagMax_s = 600.0, kGainMax = 10.0;

template <auto Channel, auto Field>
constexpr auto error_of = +[](VehicleParameters& car) -> double& { return car.sensors.*Channel.*Field; };

/// Rows and the text that they point to.
class Rows {
 public:
  /// `suffix` ends the keys in the instrument's unit: offset_v.
  template <auto Channel>
  void add(const std::string& name, std::string_view unit, const std::string& suffix, const std::string& what) {
    using E = ReadingErrors;
    const auto row = [&](const std::string& field, std::string_view of_unit, double low, double high,
                         ParameterAccess access, const std::string& meaning) {
      const std::string& key = text_.emplace_back(fmt::format("sensors.{}.{}", name, field));
      const std::string& words = text_.emplace_back(fmt::format("{}: {}", what, meaning));
      rows_.push_back({key, of_unit, low, high, Presence::kQuiet, access, words});
    };
    row("offset_" + suffix, unit, -1e4, 1e4, error_of<Channel, &E::offset>, "added to the reading");
    row("gain", "1", 0.0, kGainMax, error_of<Channel, &E::gain>, "factor on the reading");
    row("delay_s", "s", 0.0, kDelayMax_s, error_of<Channel, &E::delay_s>, "age of the reading, in steps of 0.01 s");
    row("lag_s", "s", 0.0, kLagMax_s, error_of<Channel, &E::lag_s>, "time constant of its first-order lag");
    row("min_" + suffix, unit, -kAny, kAny, error_of<Channel, &E::min>, "it reads no less");
    row("max_" + suffix, unit, -kAny, kAny, error_of<Channel, &E::max>, "it reads no more");
  }
  [[nodiscard]] std::span<const ParameterRow> all() const { return rows_; }

 private:
  std::vector<ParameterRow> rows_;
  std::deque<std::string> text_;  // elements stay where they are
};

Rows made() {
  Rows rows;
  rows.add<&S::all_cells>("cells", "V", "v", "every cell's voltage");
  rows.add<&S::all_thermistors>("thermistors", "degC", "c", "every thermistor");
  rows.add<&S::pack_current>("pack_current", "A", "a", "pack current");
  rows.add<&S::pack_voltage>("pack_voltage", "V", "v", "pack voltage");
  rows.add<&S::dc_link_voltage>("dc_link_voltage", "V", "v", "DC-link voltage");
  rows.add<&S::phase_current>("phase_current", "A", "a", "phase current");
  rows.add<&S::motor_speed>("motor_speed", "rpm", "rpm", "motor speed");
  rows.add<&S::motor_temperature>("motor_temperature", "degC", "c", "motor temperature");
  rows.add<&S::inverter_temperature>("inverter_temperature", "degC", "c", "inverter temperature");
  rows.add<&S::wheel_front_left>("wheel_front_left", "m/s", "mps", "wheel speed, front left");
  rows.add<&S::wheel_front_right>("wheel_front_right", "m/s", "mps", "wheel speed, front right");
  rows.add<&S::wheel_rear_left>("wheel_rear_left", "m/s", "mps", "wheel speed, rear left");
  rows.add<&S::wheel_rear_right>("wheel_rear_right", "m/s", "mps", "wheel speed, rear right");
  rows.add<&S::apps1>("apps1", "V", "v", "accelerator sensor 1");
  rows.add<&S::apps2>("apps2", "V", "v", "accelerator sensor 2");
  rows.add<&S::brake_front>("brake_front", "bar", "bar", "brake pressure, front");
  rows.add<&S::brake_rear>("brake_rear", "bar", "bar", "brake pressure, rear");
  return rows;
}

/// The channel's errors, made when it is the first of its kind.
template <auto Channels, auto Field>
void put(VehicleParameters& car, std::size_t index, double value) {
  auto& channels = car.sensors.*Channels;
  if (channels.size() <= index) channels.resize(index + 1);
  channels[index].*Field = value;
}
template <auto Channels, auto Field>
std::optional<double> get(const VehicleParameters& car, std::size_t index) {
  const auto& channels = car.sensors.*Channels;
  return index < channels.size() ? channels[index].*Field : std::nullopt;
}

using E = ChannelErrors;
template <auto Channels, auto Field>
constexpr IndexedRow channel(std::string_view prefix, std::string_view field, std::string_view unit, double low,
                             double high, std::string_view words) {
  return {prefix, field, unit, low, high, put<Channels, Field>, get<Channels, Field>, words};
}
constexpr IndexedRow kChannelRows[] = {
    channel<&S::cells, &E::offset>("sensors.cells", "offset_v", "V", -1e4, 1e4, "of this cell's voltage alone"),
    channel<&S::cells, &E::gain>("sensors.cells", "gain", "1", 0, kGainMax, "of this cell's voltage alone"),
    channel<&S::cells, &E::delay_s>("sensors.cells", "delay_s", "s", 0, kDelayMax_s, "of this cell's voltage alone"),
    channel<&S::cells, &E::lag_s>("sensors.cells", "lag_s", "s", 0, kLagMax_s, "of this cell's voltage alone"),
    channel<&S::cells, &E::min>("sensors.cells", "min_v", "V", -kAny, kAny, "of this cell's voltage alone"),
    channel<&S::cells, &E::max>("sensors.cells", "max_v", "V", -kAny, kAny, "of this cell's voltage alone"),
    channel<&S::thermistors, &E::offset>("sensors.thermistors", "offset_c", "degC", -1e4, 1e4,
                                         "of this thermistor alone"),
    channel<&S::thermistors, &E::gain>("sensors.thermistors", "gain", "1", 0, kGainMax, "of this thermistor alone"),
    channel<&S::thermistors, &E::delay_s>("sensors.thermistors", "delay_s", "s", 0, kDelayMax_s,
                                          "of this thermistor alone"),
    channel<&S::thermistors, &E::lag_s>("sensors.thermistors", "lag_s", "s", 0, kLagMax_s, "of this thermistor alone"),
    channel<&S::thermistors, &E::min>("sensors.thermistors", "min_c", "degC", -kAny, kAny, "of this thermistor alone"),
    channel<&S::thermistors, &E::max>("sensors.thermistors", "max_c", "degC", -kAny, kAny, "of this thermistor alone"),
};

}  // namespace

std::span<const ParameterRow> instrument_parameter_rows() {
  static const Rows rows = made();
  return rows.all();
}

std::span<const IndexedRow> instrument_channel_rows() { return kChannelRows; }

}  // namespace voltlap::plant
