// SPDX-License-Identifier: Apache-2.0
#include "io/logs/role_source.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>

#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr double kAny = 1e300;

struct Role {
  std::string_view name;
  RoleRange range;
  std::string_view quantity;
};
// Ranges are wider than any car's: what lies beyond is no measurement. A lithium cell reads 1.0 to 4.45 V; recorded
// buses carry 0.0, 0.51, 4.48 and 6.55 V for cells without a reading.
constexpr std::array kRoles{Role{"time", {-kAny, kAny}, "time"},
                            Role{"current", {-5000, 5000}, "current"},
                            Role{"voltage", {-kAny, kAny}, "voltage"},
                            Role{"pack_voltage", {-kAny, kAny}, "voltage"},
                            Role{"bus_voltage", {-kAny, kAny}, "voltage"},
                            Role{"cell_voltage_<n>", {1.0, 4.45}, "voltage"},
                            Role{"temperature_<n>", {-45, 130}, "temperature"},
                            Role{"ambient", {-45, 70}, "temperature"},
                            Role{"charge_ah", {-kAny, kAny}, "charge"},
                            Role{"charged_ah", {-kAny, kAny}, "charge"},
                            Role{"discharged_ah", {-kAny, kAny}, "charge"},
                            Role{"soc", {-0.1, 1.1}, "share"},
                            Role{"speed", {-60, 120}, "speed"},
                            Role{"wheel_speed_<n>", {-60, 120}, "speed"},
                            Role{"lateral_acceleration", {-60, 60}, "acceleration"},
                            Role{"accelerator", {-0.2, 1.2}, "share"},
                            Role{"brake", {-0.2, 1.2}, "share"},
                            Role{"brake_pressure", {-20, 400}, "pressure"},
                            Role{"motor_speed", {-40000, 40000}, "rotation"},
                            Role{"motor_torque", {-5000, 5000}, "torque"},
                            Role{"motor_current", {-5000, 5000}, "current"},
                            Role{"discharge_limit", {0, 5000}, "current"},
                            Role{"charge_limit", {0, 5000}, "current"},
                            Role{"fault_<n>", {-kAny, kAny}, "number"}};

constexpr std::array kUnits{
    Unit{"1", 1, 0, ""},
    Unit{"s", 1, 0, "time"},
    Unit{"ms", 1e-3, 0, "time"},
    Unit{"us", 1e-6, 0, "time"},
    Unit{"min", 60, 0, "time"},
    Unit{"h", 3600, 0, "time"},
    Unit{"A", 1, 0, "current"},
    Unit{"mA", 1e-3, 0, "current"},
    Unit{"V", 1, 0, "voltage"},
    Unit{"mV", 1e-3, 0, "voltage"},
    Unit{"degC", 1, 0, "temperature"},
    Unit{"K", 1, -273.15, "temperature"},
    Unit{"degF", 5.0 / 9.0, -160.0 / 9.0, "temperature"},
    Unit{"Ah", 1, 0, "charge"},
    Unit{"mAh", 1e-3, 0, "charge"},
    Unit{"As", 1.0 / 3600, 0, "charge"},
    Unit{"%", 0.01, 0, "share"},
    Unit{"m/s", 1, 0, "speed"},
    Unit{"km/h", 1 / 3.6, 0, "speed"},
    Unit{"mph", 0.44704, 0, "speed"},
    Unit{"m/s2", 1, 0, "acceleration"},
    Unit{"g", 9.80665, 0, "acceleration"},
    Unit{"rpm", 1, 0, "rotation"},
    Unit{"bar", 1, 0, "pressure"},
    Unit{"kPa", 0.01, 0, "pressure"},
    Unit{"psi", 0.0689476, 0, "pressure"},
    Unit{"Nm", 1, 0, "torque"}};

constexpr std::string_view kNumber = "<n>";

bool fits(std::string_view name, std::string_view role) {
  if (name == role) return true;
  const auto number = number_in(role, name);
  return number.has_value() && *number > 0 && name[role.find(kNumber)] != '0';
}

const Role* role_of(std::string_view name) {
  const auto* at = std::find_if(kRoles.begin(), kRoles.end(), [&](const Role& role) { return fits(name, role.name); });
  return at == kRoles.end() ? nullptr : at;
}

}  // namespace

bool is_role(std::string_view name) {
  return role_of(name) != nullptr;
}

std::vector<std::string_view> role_names() {
  std::vector<std::string_view> out;
  for (const Role& role : kRoles) out.push_back(role.name);
  return out;
}

RoleRange role_range(std::string_view name) {
  const Role* role = role_of(name);
  return role == nullptr ? RoleRange{-kAny, kAny} : role->range;
}

bool unit_fits(const Unit& unit, std::string_view name) {
  const Role* role = role_of(name);
  return unit.quantity.empty() || role == nullptr || unit.quantity == role->quantity;
}

std::vector<std::string_view> units_of(std::string_view role) {
  std::vector<std::string_view> out;
  for (const Unit& unit : kUnits) {
    if (unit_fits(unit, role)) out.push_back(unit.name);
  }
  return out;
}

bool is_numbered(std::string_view pattern) {
  return pattern.find(kNumber) != std::string_view::npos;
}

std::string with_number(std::string pattern, long n) {
  const std::size_t at = pattern.find(kNumber);
  return at == std::string::npos ? pattern : pattern.replace(at, kNumber.size(), fmt::format("{}", n));
}

std::optional<long> number_in(std::string_view pattern, std::string_view name) {
  const std::size_t at = pattern.find(kNumber);
  if (at == std::string_view::npos) return std::nullopt;
  const std::string_view stem = pattern.substr(0, at), tail = pattern.substr(at + kNumber.size());
  if (name.size() <= stem.size() + tail.size() || !name.starts_with(stem) || !name.ends_with(tail))
    return std::nullopt;
  const std::string_view digits = name.substr(at, name.size() - stem.size() - tail.size());
  if (!std::all_of(digits.begin(), digits.end(), [](unsigned char c) { return std::isdigit(c); }))
    return std::nullopt;
  long n = 0;
  const auto [end, error] = std::from_chars(digits.data(), digits.data() + digits.size(), n);
  return error == std::errc{} ? std::optional<long>(n) : std::nullopt;
}

Unit unit_of(const std::string& place, const std::string& name) {
  const auto found =
      std::find_if(kUnits.begin(), kUnits.end(), [&](const Unit& unit) { return unit.name == name; });
  if (found != kUnits.end()) return *found;
  std::vector<std::string_view> known;
  for (const Unit& unit : kUnits) known.push_back(unit.name);
  throw InputError(place, fmt::format("unit \"{}\"", name), fmt::format("one of {}", fmt::join(known, ", ")),
                   "Use one of these with scale and offset");
}

}  // namespace voltlap::plant
