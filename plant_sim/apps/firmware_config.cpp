// SPDX-License-Identifier: Apache-2.0
#include "apps/firmware_config.hpp"

#include <algorithm>
#include <cmath>
#include <initializer_list>
#include <numbers>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "apps/firmware_circuit.hpp"
#include "apps/firmware_keys.hpp"
#include "apps/firmware_units.hpp"
#include "base/interpolate.hpp"
#include "car/battery/branch_reduction.hpp"
#include "car/battery/cell_tables.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"

namespace voltlap::plant {
namespace {

constexpr int kResistancePoints = 21;   // SOC in steps of 5 %
constexpr double kLeastResistance = 1e-6;  // ohm; a polarization that is taken away leaves something

CellVoltage cell_volts(double v) { return units<CellVoltage>(v, 1e4); }

/// All of a cell's resistance, as a slow load feels it, for the whole parallel group [ohm].
double group_resistance(const VehicleParameters& car, const CellTables& tables, double soc, double temperature_c) {
  if (car.bms.resistance_ohm > 0.0) {
    const double change = car.bms.resistance_per_kelvin * (temperature_c - car.cell.reference_temperature_c);
    return car.bms.resistance_ohm * (1.0 + change);
  }
  const CircuitParameters p = tables.circuit(soc, temperature_c, car.cell.reference_current_a);
  const double all = total_ohm(p) + car.cell.effects.polarization_ohm;
  return std::max(kLeastResistance, all) / car.battery.cells_in_parallel;
}

/// SOC of the OCV table in thousandths: both ends, then again and again where straight lines are farthest from the
/// curve, until they are within a step of it or the table is full. A cell's curve bends most near empty.
std::vector<int> ocv_points(const CellTables& tables) {
  constexpr int kFull = 1000;
  constexpr double kStep = 1e-4;
  const auto curve = [&](int at) { return tables.ocv(static_cast<double>(at) / kFull).voltage_v; };
  std::vector<int> points{0, kFull};
  while (points.size() < bms::kMaxTablePoints) {
    double farthest = kStep;
    int place = -1;
    for (std::size_t k = 1; k < points.size(); ++k) {
      const int left = points[k - 1], right = points[k];
      for (int at = left + 1; at < right; ++at) {
        const double straight = curve(left) + (curve(right) - curve(left)) * (at - left) / (right - left);
        if (std::abs(curve(at) - straight) <= farthest) continue;
        farthest = std::abs(curve(at) - straight);
        place = at;
      }
    }
    if (place < 0) break;
    points.insert(std::upper_bound(points.begin(), points.end(), place), place);
  }
  return points;
}

void fill_ocv(const CellTables& tables, bms::OcvTable& table) {
  std::int32_t last = 0;
  for (const int at : ocv_points(tables)) {
    table.soc[table.count] = Soc::from_raw(at * 1000);
    // A plateau of the curve still rises by one step of 0.1 mV a point: the BMS inverts the table.
    last = std::max(cell_volts(tables.ocv(1e-3 * at).voltage_v).raw(), last + 1);
    table.voltage[table.count++] = CellVoltage::from_raw(last);
  }
}

/// The BMS's own points, where the car gives them: 0.1 mV and a millionth of the charge fine.
void fill_own_ocv(const BmsSection& own, bms::OcvTable& table) {
  VOLTLAP_DEMAND(own.ocv_soc.size() == own.ocv_v.size() && own.ocv_v.size() <= bms::kMaxTablePoints);
  for (std::size_t i = 0; i < own.ocv_v.size(); ++i) {
    table.soc[i] = units<Soc>(own.ocv_soc[i], 1e6);
    table.voltage[i] = cell_volts(own.ocv_v[i]);
  }
  table.count = static_cast<std::uint8_t>(own.ocv_v.size());
}

void fill_tables(const VehicleParameters& car, bms::Config& config) {
  const CellTables tables(car.cell);
  const double reference = car.cell.reference_temperature_c;
  if (car.bms.ocv_v.empty()) {
    fill_ocv(tables, config.ocv);
  } else {
    fill_own_ocv(car.bms, config.ocv);
  }
  for (int i = 0; i < kResistancePoints; ++i) {
    const double soc = static_cast<double>(i) / (kResistancePoints - 1);
    config.resistance.soc[i] = units<Soc>(soc, 1e6);
    config.resistance.resistance[i] = units<Resistance>(group_resistance(car, tables, soc, reference), 1e6);
  }
  config.resistance.count = kResistancePoints;
  config.resistance.reference = celsius(reference);
  // Relative change per kelvin of the resistance at the reference temperature: (dR/dT) / R_reference.
  constexpr double kMiddle = 0.5, kSpanK = 5.0;
  const double warm = group_resistance(car, tables, kMiddle, reference + kSpanK);
  const double cold = group_resistance(car, tables, kMiddle, reference - kSpanK);
  const double slope_per_kelvin = (warm - cold) / (2.0 * kSpanK) / group_resistance(car, tables, kMiddle, reference);
  config.resistance.ppm_per_kelvin = static_cast<std::int32_t>(std::lround(1e6 * slope_per_kelvin));
  if (config.soc_method == bms::SocMethod::kEkf) fill_branches(car, tables, config);
}

/// The firmware's own interpolation, in volts.
double table_voltage(const bms::OcvTable& table, double soc) {
  return 1e-4 * interpolate(table.soc, table.voltage, table.count, units<Soc>(soc, 1e6)).raw();
}

void round_ocv(const CellTables& tables, const bms::OcvTable& table, TableRounding& out) {
  constexpr double kStep = 1e-4, kSamples = 2000.0;
  for (int i = 0; i < table.count; ++i) {
    const double off = 1e-4 * table.voltage[i].raw() - tables.ocv(1e-6 * table.soc[i].raw()).voltage_v;
    const bool raised = off > kStep;
    if (raised) ++out.ocv_raised_points;
    double& largest = raised ? out.ocv_raised_v : out.ocv_points_v;
    largest = std::max(largest, std::abs(off));
  }
  constexpr std::int32_t kMillivolt = 10;
  const auto soc_at = [&](std::int32_t raw) {
    return 1e-6 * interpolate(table.voltage, table.soc, table.count, CellVoltage::from_raw(raw)).raw();
  };
  for (std::int32_t raw = table.voltage[0].raw(); raw < table.voltage[table.count - 1].raw(); ++raw) {
    const double span = soc_at(raw + kMillivolt) - soc_at(raw);
    if (span <= out.soc_per_mv) continue;
    out.soc_per_mv = span;
    out.soc_per_mv_at = soc_at(raw) + 0.5 * span;
  }
  for (double k = 0.0; k <= kSamples; k += 1.0) {
    const double off = std::abs(table_voltage(table, k / kSamples) - tables.ocv(k / kSamples).voltage_v);
    if (off <= out.ocv_between_v) continue;
    out.ocv_between_v = off;
    out.ocv_between_soc = k / kSamples;
  }
}

AppsCurve curve(const master::AppsChannel& channel) {
  constexpr double kPerVolt = 1e4;
  return {channel.released.raw() / kPerVolt, channel.full.raw() / kPerVolt};
}

std::string place_of(const VehicleParameters& car, const Origins& origins, const char* key) {
  const auto given = origins.find(key);
  return given == origins.end() ? fmt::format("vehicle {}, {}", car.name, key) : given->second;
}

/// Of a key that is a word: its place among them.
std::size_t word_index(const VehicleParameters& car, const Origins& origins, const char* key, const std::string& word,
                       std::initializer_list<const char*> words) {
  std::size_t index = 0;
  for (const char* known : words) {
    if (word == known) return index;
    ++index;
  }
  throw InputError(place_of(car, origins, key), '"' + word + '"', fmt::format("{}", fmt::join(words, " or ")),
                   "Choose one of them");
}

Duration whole_ms(double s) { return Duration::from_ms(static_cast<std::int32_t>(std::lround(1e3 * s))); }

/// Values that only mean something beside another.
void check_beliefs(const VehicleParameters& car, const Origins& origins) {
  const BmsSection& own = car.bms;
  if (own.ocv_soc.size() != own.ocv_v.size() || own.ocv_v.size() == 1 || own.ocv_v.size() > bms::kMaxTablePoints) {
    throw InputError(place_of(car, origins, own.ocv_v.empty() ? "bms.ocv_soc" : "bms.ocv_v"),
                     fmt::format("{} points of bms.ocv_soc and {} of bms.ocv_v", own.ocv_soc.size(), own.ocv_v.size()),
                     fmt::format("2 to {} points of each, as many of one as of the other", bms::kMaxTablePoints),
                     "Complete the two lists, or leave both out");
  }
  if (own.resistance_per_kelvin != 0.0 && own.resistance_ohm == 0.0) {
    throw InputError(place_of(car, origins, "bms.resistance_per_kelvin"),
                     fmt::format("{:g} 1/K", own.resistance_per_kelvin),
                     "bms.resistance_ohm beside it: without it the BMS takes both from the cell file",
                     "Give bms.resistance_ohm, or leave bms.resistance_per_kelvin out");
  }
  if (own.energy_to_go_km != 0.0 && own.soc_method == "none") {
    throw InputError(place_of(car, origins, "bms.energy_to_go_km"),
                     fmt::format("{:g} km, with bms.soc_method none", own.energy_to_go_km),
                     "bms.soc_method coulomb or ekf beside it: without a state of charge there is nothing to spread",
                     "Set bms.soc_method = \"coulomb\" too, or bms.energy_to_go_km = 0");
  }
  if (own.soc_derating_start != 0.0 && own.soc_method == "none") {
    throw InputError(place_of(car, origins, "bms.soc_derating_start"),
                     fmt::format("{:g}, with bms.soc_method none", own.soc_derating_start),
                     "bms.soc_method coulomb or ekf beside it: without a state of charge nothing says when it is low",
                     "Set bms.soc_method = \"coulomb\" too, or bms.soc_derating_start = 0");
  }
  if (own.limit_method == "ahead" && own.soc_method != "ekf") {
    throw InputError(place_of(car, origins, "bms.limit_method"),
                     fmt::format("ahead, with bms.soc_method {}", own.soc_method),
                     "bms.soc_method ekf beside it: the limit looks ahead from a filter of every cell",
                     "Set bms.soc_method = \"ekf\" too, or choose bms.limit_method equation or table");
  }
  if (!bms::check::is_limit_horizon(whole_ms(own.limit_horizon_s))) {
    throw InputError(place_of(car, origins, "bms.limit_horizon_s"), fmt::format("{:g} s", own.limit_horizon_s),
                     "1, 10 or 30 s, or 0 for ever", "Choose one of them");
  }
}

/// What the pack's voltage falls by at once [ohm], of a cool pack that is not full: the controller's first pull is
/// planned with it, what follows with what it measures.
Resistance fresh_pack_resistance(const VehicleParameters& car) {
  constexpr double kCool_c = 10.0, kLow = 0.2;
  const CellTables tables(car.cell);
  const double cell = tables.circuit(kLow, kCool_c, car.cell.reference_current_a).r0_ohm;
  const double pack = car.battery.cells_in_series * cell / car.battery.cells_in_parallel +
                      car.battery.contact_resistance_ohm + car.contactors.resistance_ohm;
  return min(units<Resistance>(pack, 1e6), master::check::kPackResistanceMax);
}

InverterProtocol inverter_protocol(const VehicleParameters& car) {
  if (car.inverter.protocol == "amk") return InverterProtocol::kAmk;
  return car.inverter.protocol == "pm100" ? InverterProtocol::kPm100 : InverterProtocol::kPhaseCurrent;
}

}  // namespace

bms::Config bms_config(const VehicleParameters& car, const Origins& origins) {
  bms::Config config;
  check_beliefs(car, origins);
  fill_from_keys(car, config);
  config.soc_method = static_cast<bms::SocMethod>(
      word_index(car, origins, "bms.soc_method", car.bms.soc_method, {"none", "coulomb", "ekf"}));
  config.limit_method = static_cast<bms::LimitMethod>(
      word_index(car, origins, "bms.limit_method", car.bms.limit_method, {"equation", "table", "ahead"}));
  config.inverter_protocol = inverter_protocol(car);
  config.limit_horizon = whole_ms(car.bms.limit_horizon_s);
  const double capacity_ah =
      car.bms.capacity_ah > 0.0 ? car.bms.capacity_ah : car.cell.capacity_ah * car.battery.cells_in_parallel;
  const double motor_nm_per_a = car.master.motor_constant_nm_per_a.value_or(car.motor.constant_nm_per_a);
  config.motor_constant_unm_per_a = static_cast<std::int32_t>(std::lround(1e6 * motor_nm_per_a));
  config.capacity_mah = static_cast<std::int32_t>(std::lround(capacity_ah * 1e3));
  const double m_per_turn = 2.0 * std::numbers::pi * car.tyres.radius_m / car.powertrain.final_drive;
  config.um_per_motor_turn = static_cast<std::int32_t>(
      std::lround(std::min(1e6 * m_per_turn, 1.0 * bms::check::kMotorTurnMaxUm)));
  fill_tables(car, config);
  refuse(refusal(car, config), car, origins);
  VOLTLAP_DEMAND(bms::config_check(config) == bms::ConfigError::kNone);
  return config;
}

TableRounding table_rounding(const VehicleParameters& car, const bms::Config& config) {
  constexpr double kCoarsest = 0.05, kFlattest = 0.2;
  const CellTables tables(car.cell);
  TableRounding out;
  round_ocv(tables, config.ocv, out);
  const std::string place = "cell " + car.cell.name;
  if (out.soc_per_mv > kFlattest) {
    throw InputError(place + ", ocv",
                     fmt::format("a curve so flat at SOC {:.2f} that a millivolt is {:.0f} % of the charge",
                                 out.soc_per_mv_at, 100.0 * out.soc_per_mv),
                     fmt::format("one that rises by a millivolt or more every {:g} % of charge", 100.0 * kFlattest),
                     "The BMS starts its count from the OCV: check the curve, or choose a BMS without it");
  }
  for (int i = 0; i < config.resistance.count; ++i) {
    const double soc = 1e-6 * config.resistance.soc[i].raw(),
                 exact = group_resistance(car, tables, soc, car.cell.reference_temperature_c),
                 share = std::abs(1e-6 * config.resistance.resistance[i].raw() - exact) / exact;
    out.resistance_points_share = std::max(out.resistance_points_share, share);
    if (share <= kCoarsest) continue;
    throw InputError(place + ", r0 r1 r2", fmt::format("{:g} uOhm at SOC {:.2f}", 1e6 * exact, soc),
                     "10 uOhm to 2 kOhm: the firmware counts in microohms", "Check the unit of the resistances (ohm)");
  }
  return out;
}

master::Config master_config(const VehicleParameters& car, const Origins& origins) {
  master::Config config;
  fill_from_keys(car, config);
  config.pack_resistance = fresh_pack_resistance(car);
  const std::size_t arbitration =
      word_index(car, origins, "master.arbitration", car.master.arbitration, {"power_balance", "literal"});
  config.arbitration = arbitration == 0 ? master::Arbitration::kPowerBalance : master::Arbitration::kLiteral;
  config.inverter_protocol = inverter_protocol(car);
  refuse(refusal(car, config), car, origins);
  VOLTLAP_DEMAND(master::config_check(config) == master::ConfigError::kNone);
  return config;
}

PedalSensors pedal_sensors(const master::Config& config) {
  VOLTLAP_DEMAND(master::config_check(config) == master::ConfigError::kNone);
  return {.apps1 = curve(config.apps1), .apps2 = curve(config.apps2)};
}

}  // namespace voltlap::plant
