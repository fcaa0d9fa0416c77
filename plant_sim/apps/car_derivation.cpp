// SPDX-License-Identifier: Apache-2.0
#include "apps/car_derivation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "car/vehicle/chassis.hpp"
#include "core/demand.hpp"
#include "core/errors.hpp"
#include "master/config.hpp"

namespace voltlap::plant {
namespace {

double rounded(double value, double step) { return std::round(value / step) * step; }

double cells_mass(const VehicleParameters& car) { return pack_mass(car) / car.battery.mass_over_cells; }

double full_voltage(const VehicleParameters& car) {
  return car.battery.cells_in_series * CellTables(car.cell).ocv_v(1.0, car.battery.initial_temperature_c);
}

class Derivation {
 public:
  explicit Derivation(const GivenKeys& given) : given_(given) {}

  [[nodiscard]] bool given(std::string_view key) const { return given_.contains(key); }
  void put(const std::string& key, double value, const std::string& why) {
    VOLTLAP_DEMAND(std::isfinite(value));
    if (!given(key)) out_.push_back({key, fmt::format("{:.6g}", value), why});
  }
  [[nodiscard]] std::vector<DerivedNumber> take() { return std::move(out_); }

 private:
  const GivenKeys& given_;
  std::vector<DerivedNumber> out_;
};

void derive_drive(const VehicleParameters& car, Derivation& out) {
  if (!out.given("motor.model") || car.motor.model.empty()) return;
  const double peak_nm = *std::max_element(car.motor.curve_torque_nm.begin(), car.motor.curve_torque_nm.end());
  const double wanted_a = std::ceil(peak_nm / car.motor.constant_nm_per_a / car.motor.efficiency);
  const double most_a = 1e-3 * master::check::kPhaseCurrentMax.raw();
  out.put("inverter.current_max_a", std::min(wanted_a, most_a),
          wanted_a <= most_a ? fmt::format("derived: takes the motor to its {:g} Nm", peak_nm)
                             : fmt::format("the firmware's largest; {:g} A make {:g} Nm", wanted_a, peak_nm));
  out.put("inverter.efficiency", 0.97, "assumed: 96 to 98 % are usual");
  out.put("powertrain.driveline_efficiency", 0.96, "assumed: a chain or a set of gears");
  out.put("powertrain.driveline_inertia_kg_m2", 0.3, "assumed: rear wheels, sprocket, shafts");
  // The study's low-voltage load stands for every loss that it left out; here they have terms of their own.
  out.put("tyres.cornering_stiffness_per_rad", 20.0, "assumed, 15 to 30 are usual");
  out.put("low_voltage.power_w", 250.0, "assumed: pumps, fans, electronics");
}

/// A link that fits the voltage: less capacitance at more volts, below 60 V in good time, and precharged beside the
/// bleed resistor to more than the BMS waits for.
void derive_dc_link(const VehicleParameters& base, const VehicleParameters& car, Derivation& out) {
  constexpr double kSafe_v = 60.0, kDischarge_s = 4.0, kPrechargeTau_s = 0.04, kSameClass = 0.25;
  const double volts = full_voltage(car), before = full_voltage(base);
  if (std::abs(volts / before - 1.0) < kSameClass) return;
  const double farad =
      std::max(1e-5, rounded(base.contactors.dc_link_capacitance_f * std::min(1.0, before / volts), 1e-5));
  out.put("contactors.dc_link_capacitance_f", farad, "assumed: inverters of this voltage");
  if (volts > kSafe_v) {
    const double ohm = kDischarge_s / farad / std::log(volts / kSafe_v);
    out.put("contactors.bleed_resistance_ohm", std::clamp(rounded(ohm, 100.0), 100.0, 1e5),
            fmt::format("derived: {:.0f} to 60 V in 4 s (EV.7.2.2 allows 5 s)", volts));
  }
  out.put("contactors.precharge_resistance_ohm", rounded(kPrechargeTau_s / farad, 10.0),
          "derived: full in an eighth of a second");
}

void derive_pack(const VehicleParameters& base, const VehicleParameters& car, Derivation& out) {
  const BatterySection& battery = car.battery;
  const bool cell = out.given("battery.cell"), parallel = out.given("battery.cells_in_parallel");
  if (!cell && !parallel && !out.given("battery.cells_in_series")) return;
  if (cell || parallel) {
    constexpr double kFirmwareMost_a = 1000.0;
    constexpr double kUsualRate = 3.0;  // 1/h
    const double known_a = car.cell.current_breakpoints_a.back();  // 0: tables that are the same at any current
    const double each_a = known_a > 0.0 ? known_a : rounded(kUsualRate * car.cell.capacity_ah, 0.1);
    out.put("bms.discharge_current_max_a", std::min(kFirmwareMost_a, each_a * battery.cells_in_parallel),
            known_a > 0.0
                ? fmt::format("derived: {} x {:g} A, as far as the cell is known", battery.cells_in_parallel, each_a)
                : fmt::format("assumed: {} x {:g} A, 3C; the cell's file says no largest current",
                              battery.cells_in_parallel, each_a));
    const double one_c = rounded(car.cell.capacity_ah * battery.cells_in_parallel, 1.0);
    out.put("bms.charge_current_max_a", std::clamp(one_c, 1.0, kFirmwareMost_a), "derived: 1C");
    constexpr double kHalf = 0.5;
    out.put("bms.charger_current_max_a", std::clamp(rounded(kHalf * one_c, 1.0), 1.0, kFirmwareMost_a),
            "derived: half of 1C");
  }
  constexpr double kFifth = 0.2;
  out.put("sensors.temperature_count", std::ceil(kFifth * battery.cells_in_series - 1e-9),
          "derived: a fifth of the cells (EV.7.5)");
  out.put("inverter.dc_voltage_min_v", std::floor(battery.cells_in_series * car.cell.voltage_min_v * 2.0 / 3.0),
          "derived: two thirds of the empty pack");
  out.put("assertions.battery_temperature_max_c", 60.0, "Formula SAE rules, EV.7.5");
  derive_dc_link(base, car, out);
}

/// Brakes are built for their car: as much force for each kilogram, whatever the wheel.
void derive_brakes(const VehicleParameters& base, const VehicleParameters& car, Derivation& out) {
  constexpr double kAsGood = 0.02;
  const double heavier = total_mass(car) * car.tyres.radius_m / (total_mass(base) * base.tyres.radius_m);
  if (std::abs(heavier - 1.0) < kAsGood) return;
  out.put("brakes.force_scale", std::min(5.0, rounded(base.brakes.force_scale * heavier, 0.01)),
          fmt::format("derived: as strong for {:.0f} kg as those of {} for {:.0f} kg", total_mass(car), base.name,
                      total_mass(base)));
}

}  // namespace

std::vector<DerivedNumber> derive_mass(const VehicleParameters& base, const VehicleParameters& car,
                                       const GivenKeys& given, double on_scales_kg) {
  Derivation out(given);
  const bool weighed = on_scales_kg > 0.0;
  if (out.given("vehicle.mass_kg") || out.given("vehicle.mass_without_pack_kg")) {
    if (!weighed) return {};
    throw InputError("--mass", "a second mass beside --set vehicle.mass_kg or vehicle.mass_without_pack_kg",
                     "one of them", "Leave one out");
  }
  // A pack that is built has a housing, busbars and relays; the study's are their cells' mass alone.
  constexpr double kUsual = 1.3;
  const bool known = out.given("battery.mass_over_cells") || base.battery.mass_over_cells > 1.0;
  const double over_cells = known ? car.battery.mass_over_cells : kUsual;
  if (!known) out.put("battery.mass_over_cells", kUsual, "assumed: housing, busbars; 1.2 to 1.5 is usual");
  if (!weighed && base.vehicle.mass_kg <= 0.0) return out.take();

  const VehicleParameters& scales = weighed ? car : base;
  const double whole = weighed ? on_scales_kg : base.vehicle.mass_kg, pack = cells_mass(scales) * over_cells;
  constexpr double kLeast_kg = 10.0;
  if (whole - pack < kLeast_kg) {
    throw InputError(weighed ? "--mass" : "vehicle " + base.name,
                     fmt::format("{:g} kg, of which the pack of {} x {} {} is {:.1f} kg", whole,
                                 scales.battery.cells_in_series, scales.battery.cells_in_parallel, scales.cell.name,
                                 pack),
                     fmt::format("at least {:g} kg beside the pack", kLeast_kg),
                     "Give the mass of the whole car with its pack (--mass, in kg), or fewer cells");
  }
  out.put("vehicle.mass_without_pack_kg", whole - pack,
          fmt::format("{:g} kg {} less its pack of {:.1f} kg", whole,
                      weighed ? "on the scales" : "of " + base.name, pack));
  return out.take();
}

std::vector<DerivedNumber> derive_fittings(const VehicleParameters& base, const VehicleParameters& car,
                                           const GivenKeys& given) {
  VOLTLAP_DEMAND(total_mass(base) > 0.0 && total_mass(car) > 0.0);
  Derivation out(given);
  derive_drive(car, out);
  derive_pack(base, car, out);
  derive_brakes(base, car, out);
  return out.take();
}

}  // namespace voltlap::plant
