// SPDX-License-Identifier: Apache-2.0
#include "apps/master_header.hpp"

#include <fmt/format.h>

namespace voltlap::plant {
namespace {

template <class Quantity>
std::string quantity(const char* field, const char* type, Quantity value, double per_unit, const char* unit) {
  return fmt::format("  {:<66}  // {:g} {}\n", fmt::format("c.{} = {}::from_raw({});", field, type, value.raw()),
                     value.raw() * per_unit, unit);
}
std::string amperes(const char* field, Current i) { return quantity(field, "Current", i, 1e-3, "A"); }
std::string celsius(const char* field, Temperature t) { return quantity(field, "Temperature", t, 0.1, "degC"); }
std::string percent(const char* field, Ratio r) { return quantity(field, "Ratio", r, 1e-4, "%"); }
std::string bar(const char* field, Pressure p) { return quantity(field, "Pressure", p, 1e-3, "bar"); }
std::string time(const char* field, Duration t) {
  return fmt::format("  {:<66}  // {:g} s\n", fmt::format("c.{} = Duration::from_ms({});", field, t.ms()),
                     1e-3 * static_cast<double>(t.ms()));
}
std::string whole(const char* field, std::int32_t value, double per_unit, const char* unit) {
  return fmt::format("  {:<66}  // {:g} {}\n", fmt::format("c.{} = {};", field, value), value * per_unit, unit);
}
std::string channel(const char* field, const master::AppsChannel& c) {
  const auto volts = [](Potential v) { return fmt::format("Potential::from_raw({})", v.raw()); };
  return fmt::format(
      "  // released, full, range: {:g}, {:g}, {:g} to {:g} V\n  c.{} = {{{}, {},\n             {}, {}}};\n",
      1e-4 * c.released.raw(), 1e-4 * c.full.raw(), 1e-4 * c.range_min.raw(), 1e-4 * c.range_max.raw(), field,
      volts(c.released), volts(c.full), volts(c.range_min), volts(c.range_max));
}

std::string pedals(const master::Config& c) {
  return channel("apps1", c.apps1) + channel("apps2", c.apps2) +
         percent("apps_disagreement_max", c.apps_disagreement_max) +
         time("apps_implausible_time", c.apps_implausible_time) +
         time("brake_sensor_fail_time", c.brake_sensor_fail_time) +
         percent("brake_throttle_limit", c.brake_throttle_limit) +
         percent("pedal_release_level", c.pedal_release_level) + percent("pedal_dead_zone", c.pedal_dead_zone) +
         percent("pedal_at_half", c.pedal_at_half) + bar("brake_pressed_level", c.brake_pressed_level) +
         bar("brake_compare_level", c.brake_compare_level);
}

std::string request(const master::Config& c) {
  return amperes("phase_current_max", c.phase_current_max) +
         whole("request_rise_ma_per_ms", c.request_rise_ma_per_ms, 1.0, "A/s") +
         amperes("regen_current_max", c.regen_current_max) + bar("regen_full_level", c.regen_full_level);
}

std::string ceilings(const master::Config& c) {
  const bool balance = c.arbitration == master::Arbitration::kPowerBalance;
  return fmt::format("  c.arbitration = Arbitration::{};\n", balance ? "kPowerBalance" : "kLiteral") +
         whole("motor_constant_unm_per_a", c.motor_constant_unm_per_a, 1e-6, "Nm/A") +
         percent("drive_efficiency", c.drive_efficiency) + whole("power_max_mw", c.power_max_mw, 1e-6, "kW") +
         quantity("pack_resistance", "Resistance", c.pack_resistance, 1e-3, "mOhm") +
         quantity("motor_speed_max", "MotorSpeed", c.motor_speed_max, 1.0, "rpm") +
         whole("ceiling_rise_ma_per_s", c.ceiling_rise_ma_per_s, 1e-3, "A/s") + percent("trim_gain", c.trim_gain) +
         percent("trim_max", c.trim_max) + whole("trim_decay_ppm_per_s", c.trim_decay_ppm_per_s, 1e-4, "%/s") +
         amperes("battery_limit_off", c.battery_limit_off) + amperes("battery_limit_on", c.battery_limit_on) +
         quantity("regen_speed_min", "Speed", c.regen_speed_min, 1e-3, "m/s") +
         amperes("inverter_excess_max", c.inverter_excess_max) + percent("limp_share", c.limp_share) +
         celsius("motor_derate_start", c.motor_derate_start) + celsius("motor_derate_end", c.motor_derate_end) +
         celsius("inverter_derate_start", c.inverter_derate_start) +
         celsius("inverter_derate_end", c.inverter_derate_end);
}

/// What no car with one inverter of ours needs to be told.
std::string inverters(const master::Config& c) {
  if (c.inverter_protocol == InverterProtocol::kPhaseCurrent) return "";
  const std::string protocol = fmt::format("  c.inverter_protocol = {};\n", protocol_name(c.inverter_protocol));
  if (c.inverter_protocol != InverterProtocol::kAmk) return protocol;
  return protocol + amperes("motor_current_max", c.motor_current_max) +
         percent("front_drive_share", c.front_drive_share) + percent("front_brake_share", c.front_brake_share) +
         whole("nominal_torque_mnm", c.nominal_torque_mnm, 1e-3, "Nm");
}

std::string times(const master::Config& c) {
  return inverters(c) + time("ts_request_timeout", c.ts_request_timeout) + time("rtd_sound_time", c.rtd_sound_time) +
         time("rx_timeout", c.rx_timeout);
}

std::string assignments(const master::Config& c) { return pedals(c) + request(c) + ceilings(c) + times(c); }

}  // namespace

std::uint32_t configuration_number(const master::Config& config) { return number_of_text(assignments(config)); }

std::string master_header(const std::string& vehicle, const master::Config& config, const HeaderSource& source) {
  return fmt::format(
             "// The master controller's configuration for {}. Made by voltlap {}; make it again with\n//   {}\n"
             "#pragma once\n#include <cstdint>\n\n#include \"master/config.hpp\"\n\nnamespace voltlap::master {{\n\n",
             vehicle, source.version, source.command) +
         owner_lines("Master", vehicle, configuration_number(config)) +
         "inline constexpr Config kMasterConfig = [] {\n  Config c{};\n" + assignments(config) +
         "  return c;\n}();\n"
         "static_assert(config_check(kMasterConfig) == ConfigError::kNone, \"this firmware refuses the configuration: "
         "make the\"\n              \" header again\");\n\n"
         "}  // namespace voltlap::master\n";
}

}  // namespace voltlap::plant
