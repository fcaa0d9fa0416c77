// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_header.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <vector>

namespace voltlap::plant {
namespace {

/// A field of bms::Config as a line of C++.
struct Line {
  std::string assignment, meaning;
};

template <class Quantity>
Line quantity(const char* field, const char* type, Quantity value, double per_unit, const char* unit) {
  return {fmt::format("c.{} = {}::from_raw({});", field, type, value.raw()),
          fmt::format("{:g} {}", value.raw() * per_unit, unit)};
}
Line volts(const char* field, CellVoltage v) {
  return quantity(field, "CellVoltage", v, 1e-4, "V");
}
Line amperes(const char* field, Current i) {
  return quantity(field, "Current", i, 1e-3, "A");
}
Line celsius(const char* field, Temperature t) {
  return quantity(field, "Temperature", t, 0.1, "degC");
}
Line percent(const char* field, Ratio r) {
  return quantity(field, "Ratio", r, 1e-4, "%");
}
Line time(const char* field, Duration t) {
  return {fmt::format("c.{} = Duration::from_ms({});", field, t.ms()),
          fmt::format("{:g} s", 1e-3 * static_cast<double>(t.ms()))};
}
Line whole(const char* field, std::int64_t value, const char* unit) {
  return {fmt::format("c.{} = {};", field, value), unit};
}

const char* name_of(bms::LimitMethod method) {
  switch (method) {
    case bms::LimitMethod::kEquation: return "kEquation";
    case bms::LimitMethod::kTable: return "kTable";
    case bms::LimitMethod::kAhead: break;
  }
  return "kAhead";
}

const char* name_of(bms::SocMethod method) {
  switch (method) {
    case bms::SocMethod::kNone: return "kNone";
    case bms::SocMethod::kCoulomb: return "kCoulomb";
    case bms::SocMethod::kEkf: break;
  }
  return "kEkf";
}

/// Of the circuit, where the filter reads it.
std::vector<Line> branch_lines(const bms::BranchTable& b) {
  const auto slopes = [](const char* field, const bms::PartSlopes& s, const char* unit) {
    return Line{fmt::format("c.branches.{} = {{{}, {}, {}, {}, {}}};", field, s.series, s.branch1, s.branch2, s.time1,
                            s.time2), unit};
  };
  return {slopes("per_ampere", b.per_ampere, "1e-6/A, relative"),
          amperes("branches.current_reference", b.current_reference), amperes("branches.current_min", b.current_min),
          amperes("branches.current_max", b.current_max),
          whole("branches.warmth_count", b.warmth_count, "temperatures at which the parts are known")};
}

constexpr const char* kFillBranches =
    "    c.branches.series[i] = Resistance::from_raw(pack_tables::kSeriesResistance[i]);\n"
    "    c.branches.branch1[i] = Resistance::from_raw(pack_tables::kBranch1Resistance[i]);\n"
    "    c.branches.branch2[i] = Resistance::from_raw(pack_tables::kBranch2Resistance[i]);\n"
    "    c.branches.time1[i] = Duration::from_ms(pack_tables::kBranch1Time[i]);\n"
    "    c.branches.time2[i] = Duration::from_ms(pack_tables::kBranch2Time[i]);\n";

constexpr const char* kFillWarmth =
    "  for (std::uint8_t i = 0; i < c.branches.warmth_count; ++i) {\n"
    "    c.branches.warmth_at[i] = Temperature::from_raw(pack_tables::kWarmthAt[i]);\n"
    "    c.branches.warmth[i] = pack_tables::kWarmth[i];\n"
    "  }\n";

/// Every field: an image must not change with a default of another version.
std::vector<Line> lines_of(const bms::Config& c) {
  return {
      whole("cells_in_series", c.cells_in_series, ""),
      whole("temperature_sensors", c.temperature_sensors, ""),
      whole("capacity_mah", c.capacity_mah, "mAh of a parallel group"),
      whole("heat_capacity_j_per_k", c.heat_capacity_j_per_k, "J/K of it"),
      {fmt::format("c.soc_method = SocMethod::{};", name_of(c.soc_method)), ""},
      amperes("soc_start_current", c.soc_start_current),
      {fmt::format("c.limit_method = LimitMethod::{};", name_of(c.limit_method)), ""},
      time("limit_horizon", c.limit_horizon),
      volts("cell_voltage_min", c.cell_voltage_min),
      volts("cell_voltage_max", c.cell_voltage_max),
      amperes("discharge_current_max", c.discharge_current_max),
      amperes("charge_current_max", c.charge_current_max),
      amperes("limit_rise_per_s", c.limit_rise_per_s),
      celsius("derating_start", c.derating_start),
      celsius("charge_temperature_min", c.charge_temperature_min),
      quantity("soc_derating_start", "Soc", c.soc_derating_start, 1e-4, "%"),
      whole("energy_to_go_m", c.energy_to_go_m, "m; 0: off"),
      quantity("energy_to_go_reserve", "Soc", c.energy_to_go_reserve, 1e-4, "%"),
      whole("um_per_motor_turn", c.um_per_motor_turn, "um"),
      volts("cell_voltage_trip_low", c.cell_voltage_trip_low),
      volts("cell_voltage_trip_high", c.cell_voltage_trip_high),
      celsius("temperature_trip", c.temperature_trip),
      amperes("discharge_current_trip", c.discharge_current_trip),
      amperes("charge_current_trip", c.charge_current_trip),
      percent("voltage_mismatch", c.voltage_mismatch),
      time("voltage_trip_time", c.voltage_trip_time),
      time("temperature_trip_time", c.temperature_trip_time),
      time("measurement_lost_time", c.measurement_lost_time),
      time("current_trip_time", c.current_trip_time),
      time("mismatch_time", c.mismatch_time),
      time("implausible_time", c.implausible_time),
      whole("motor_constant_unm_per_a", c.motor_constant_unm_per_a, "uNm/A"),
      volts("cell_voltage_plausible_min", c.cell_voltage_plausible_min),
      volts("cell_voltage_plausible_max", c.cell_voltage_plausible_max),
      percent("precharge_ratio", c.precharge_ratio),
      time("precharge_timeout", c.precharge_timeout),
      time("precharge_time_min", c.precharge_time_min),
      time("precharge_time_unseen", c.precharge_time_unseen),
      whole("precharge_attempts", c.precharge_attempts, "in a row"),
      time("precharge_cooling", c.precharge_cooling),
      time("opening_time", c.opening_time),
      amperes("opening_current", c.opening_current),
      time("contactor_time", c.contactor_time),
      time("contactor_drop_time", c.contactor_drop_time),
      time("isolation_time", c.isolation_time),
      time("discharge_time", c.discharge_time),
      percent("dc_link_welded", c.dc_link_welded),
      amperes("charger_current_max", c.charger_current_max),
      volts("charge_margin", c.charge_margin),
      amperes("charge_current_end", c.charge_current_end),
      volts("balancing_voltage_min", c.balancing_voltage_min),
      volts("balancing_difference", c.balancing_difference),
      amperes("balancing_current_max", c.balancing_current_max),
      time("balancing_time_max", c.balancing_time_max),
      whole("ocv.count", c.ocv.count, "points"),
      whole("resistance.count", c.resistance.count, "points"),
      celsius("resistance.reference", c.resistance.reference),
      whole("resistance.ppm_per_kelvin", c.resistance.ppm_per_kelvin, "1e-6/K, relative"),
  };
}

/// Those of an image: the circuit of a filter is in it where there is one.
std::vector<Line> lines_of_image(const bms::Config& config) {
  std::vector<Line> lines = lines_of(config);
  if (config.inverter_protocol != InverterProtocol::kPhaseCurrent) {
    lines.push_back({fmt::format("c.inverter_protocol = {};", protocol_name(config.inverter_protocol)), ""});
  }
  if (config.soc_method == bms::SocMethod::kEkf) {
    for (Line& line : branch_lines(config.branches)) lines.push_back(std::move(line));
  }
  return lines;
}

std::string array(const char* name, const char* unit, const std::vector<std::int32_t>& raw) {
  std::string out = fmt::format("inline constexpr std::int32_t {}[] = {{  // {}\n", name, unit);
  constexpr std::size_t kPerLine = 8;
  for (std::size_t i = 0; i < raw.size(); i += kPerLine) {
    const auto end = raw.begin() + static_cast<std::ptrdiff_t>(std::min(raw.size(), i + kPerLine));
    out += fmt::format("    {},\n", fmt::join(raw.begin() + static_cast<std::ptrdiff_t>(i), end, ", "));
  }
  return out + "};\n";
}

template <class Quantity>
std::string array(const char* name, const char* unit, const Quantity* values, int count) {
  std::vector<std::int32_t> raw;
  for (int i = 0; i < count; ++i) raw.push_back(values[i].raw());
  return array(name, unit, raw);
}

/// What the parts are at a temperature.
std::string warmth_arrays(const bms::BranchTable& b) {
  std::string out = array("kWarmthAt", "0.1 degC", b.warmth_at, b.warmth_count);
  out += "inline constexpr PartShares kWarmth[] = {  // R0, R1, R2, tau1, tau2 there, ppm of the reference's\n";
  for (std::size_t i = 0; i < b.warmth_count; ++i) {
    const bms::PartShares& w = b.warmth[i];
    out += fmt::format("    {{{}, {}, {}, {}, {}}},\n", w.series, w.branch1, w.branch2, w.time1, w.time2);
  }
  return out + "};\n";
}

std::string filter_arrays(const bms::BranchTable& b, int count) {
  const auto times = [count](const char* name, const Duration* values) {
    std::vector<std::int32_t> raw;
    for (int i = 0; i < count; ++i) raw.push_back(values[i].ms());
    return array(name, "ms", raw);
  };
  return array("kSeriesResistance", "uOhm, at once", b.series, count) +
         array("kBranch1Resistance", "uOhm", b.branch1, count) + times("kBranch1Time", b.time1) +
         array("kBranch2Resistance", "uOhm", b.branch2, count) + times("kBranch2Time", b.time2) + warmth_arrays(b);
}

/// At the SOC of the resistances, for one parallel group.
std::string branch_arrays(const VehicleParameters& car, const BranchReduction& reduction) {
  const auto list = [&](const char* name, const char* unit, double per_si, const auto& value_of) {
    std::vector<std::int32_t> raw;
    for (const CircuitOf<2>& circuit : reduction.circuits)
      raw.push_back(static_cast<std::int32_t>(std::lround(per_si * value_of(circuit))));
    return array(name, unit, raw);
  };
  const double micro = 1e6 / car.battery.cells_in_parallel;
  std::string out = list("kSeriesResistance", "uOhm, at once", micro, [](const auto& c) { return c.r0_ohm; });
  out += list("kBranch1Resistance", "uOhm", micro, [](const auto& c) { return c.r_ohm[0]; });
  out += list("kBranch1Time", "ms", 1e3, [](const auto& c) { return c.tau_s[0]; });
  out += list("kBranch2Resistance", "uOhm", micro, [](const auto& c) { return c.r_ohm[1]; });
  return out + list("kBranch2Time", "ms", 1e3, [](const auto& c) { return c.tau_s[1]; });
}

std::string cell_arrays(const bms::Config& config) {
  return array("kOcvSoc", "ppm of full charge", config.ocv.soc, config.ocv.count) +
         array("kOcvVoltage", "0.1 mV", config.ocv.voltage, config.ocv.count) +
         array("kResistanceSoc", "ppm of full charge", config.resistance.soc, config.resistance.count) +
         array("kResistance", "uOhm of a parallel group, at the reference temperature",
               config.resistance.resistance, config.resistance.count);
}

std::string commented(const std::string& text) {
  std::string out;
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = text.find('\n', from);
    out += "// " + text.substr(from, end - from) + "\n";
    from = end + 1;
  }
  return out;
}

}  // namespace

std::uint32_t number_of_text(std::string_view text) {
  std::uint32_t number = 2166136261U;  // FNV-1a of 32 bits
  for (const char c : text) number = (number ^ static_cast<unsigned char>(c)) * 16777619U;
  return number == 0 ? 1 : number;
}

std::uint32_t configuration_number(const bms::Config& config) {
  std::string text = cell_arrays(config);
  if (config.soc_method == bms::SocMethod::kEkf) text += filter_arrays(config.branches, config.resistance.count);
  for (const Line& line : lines_of_image(config)) text += line.assignment;
  return number_of_text(text);
}

const char* protocol_name(InverterProtocol protocol) {
  switch (protocol) {
    case InverterProtocol::kPhaseCurrent: break;
    case InverterProtocol::kPm100: return "InverterProtocol::kPm100";
    case InverterProtocol::kAmk: return "InverterProtocol::kAmk";
  }
  return "InverterProtocol::kPhaseCurrent";
}

std::string owner_lines(const char* kind, const std::string& car, std::uint32_t number) {
  constexpr std::size_t kNameMost = 23;  // of port::ImageInfo
  std::string name = car.substr(0, kNameMost);
  for (char& c : name) {
    if (c < ' ' || c > '~' || c == '"' || c == '\\') c = '_';
  }
  return fmt::format("// Whose configuration it is, and its number, by which an image of another car is told. After a\n"
                     "// change by hand set it to 0: whose it is, is not known then.\n"
                     "inline constexpr char k{}Car[] = \"{}\";\ninline constexpr std::uint32_t k{}Number = "
                     "0x{:08X}U;\n\n", kind, name, kind, number);
}

std::string rounding_text(const bms::Config& config, const TableRounding& rounding) {
  std::string out = fmt::format(
      "OCV: {} points from {:g} to {:g} V in steps of 0.1 mV, rounded by at most {:.2f} mV.\n"
      "Between the points, straight: at most {:.1f} mV from the cell's curve, at SOC {:.3f}.\n"
      "A millivolt of reading is worth at most {:.2f} % of charge, at SOC {:.2f}.\n"
      "Resistance: {} points in steps of 1 uOhm, rounded by at most {:.2f} %.\n",
      config.ocv.count, 1e-4 * config.ocv.voltage[0].raw(), 1e-4 * config.ocv.voltage[config.ocv.count - 1].raw(),
      1e3 * rounding.ocv_points_v, 1e3 * rounding.ocv_between_v, rounding.ocv_between_soc,
      100.0 * rounding.soc_per_mv, rounding.soc_per_mv_at, config.resistance.count,
      100.0 * rounding.resistance_points_share);
  if (rounding.ocv_raised_points > 0) {
    out += fmt::format(
        "The OCV is flat in places: {} point{} raised by up to {:.1f} mV so that it rises everywhere.\n",
        rounding.ocv_raised_points, rounding.ocv_raised_points == 1 ? "" : "s", 1e3 * rounding.ocv_raised_v);
  }
  return out;
}

BranchReduction two_branch_tables(const VehicleParameters& car, const bms::Config& config) {
  std::vector<double> soc;
  for (int i = 0; i < config.resistance.count; ++i) soc.push_back(1e-6 * config.resistance.soc[i].raw());
  return reduce_branches(car.cell, soc);
}

std::string branches_text(const VehicleParameters& car, const BranchReduction& reduction) {
  if (reduction.branches == 1) return "RC branches for a filter: the cell file's one; the second is 0 ohm.\n";
  if (reduction.branches == 2) return "RC branches for a filter: the cell file's two.\n";
  return fmt::format(
      "RC branches for a filter: 2 in the place of {}. After a step of 1C, {:g} A, their voltage is off by at most "
      "{:.2f} mV, at SOC {:.2f}, RMS {:.2f} mV, from 1 to 600 s.\n",
      reduction.branches, car.cell.capacity_ah, 1e3 * reduction.largest_v, reduction.largest_at_soc,
      1e3 * reduction.rms_v);
}

std::string firmware_header(const VehicleParameters& car, const bms::Config& config, const TableRounding& rounding,
                            const BranchReduction& reduction, const HeaderSource& source) {
  std::string out = fmt::format(
      "// The BMS's configuration for the pack of {}, {} x cell {}. Made by voltlap {}; make it again with\n//   "
      "{}\n//\n",
      car.name, config.cells_in_series, car.cell.name, source.version, source.command);
  out += commented(rounding_text(config, rounding) + branches_text(car, reduction));
  out +=
      "#pragma once\n#include <cstdint>\n\n#include \"bms/config.hpp\"\n\nnamespace voltlap::bms {\nnamespace "
      "pack_tables {\n\n";
  out += cell_arrays(config);
  const bool filtered = config.soc_method == bms::SocMethod::kEkf;
  out += fmt::format("\n// For a filter: the circuit of a parallel group at kResistanceSoc, at the reference "
                     "temperature.{}\n",
                     filtered ? "" : " kPackConfig holds\n// its whole resistance alone, kResistance.");
  out += filtered ? filter_arrays(config.branches, config.resistance.count) : branch_arrays(car, reduction);
  out += "\n}  // namespace pack_tables\n\n" + owner_lines("Pack", car.name, configuration_number(config)) +
         "inline constexpr Config kPackConfig = [] {\n  Config c{};\n";
  for (const Line& line : lines_of_image(config)) {
    out += line.meaning.empty() ? fmt::format("  {}\n", line.assignment)
                                : fmt::format("  {:<66}  // {}\n", line.assignment, line.meaning);
  }
  out +=
      "  for (std::uint8_t i = 0; i < c.ocv.count; ++i) {\n"
      "    c.ocv.soc[i] = Soc::from_raw(pack_tables::kOcvSoc[i]);\n"
      "    c.ocv.voltage[i] = CellVoltage::from_raw(pack_tables::kOcvVoltage[i]);\n"
      "  }\n"
      "  for (std::uint8_t i = 0; i < c.resistance.count; ++i) {\n"
      "    c.resistance.soc[i] = Soc::from_raw(pack_tables::kResistanceSoc[i]);\n"
      "    c.resistance.resistance[i] = Resistance::from_raw(pack_tables::kResistance[i]);\n";
  if (filtered) out += kFillBranches;
  out += "  }\n";
  if (filtered) out += kFillWarmth;
  out +=
      "  return c;\n"
      "}();\n"
      "static_assert(config_check(kPackConfig) == ConfigError::kNone, \"this firmware refuses the pack: make the "
      "header again\");\n\n"
      "}  // namespace voltlap::bms\n";
  return out;
}

}  // namespace voltlap::plant
