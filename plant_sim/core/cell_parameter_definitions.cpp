// SPDX-License-Identifier: Apache-2.0
// The rows of a cell file, which stand in the section `cell` of a car, and how single cells of a pack differ.
#include "core/parameter_rows.hpp"

namespace voltlap::plant {
namespace {

using Car = VehicleParameters;
using enum Presence;

// clang-format off
const ParameterRow kRows[] = {
  {"cell.name", "-", 0, 0, kOptional, at<&Car::cell, &CellParameters::name>, "name of the cell"},
  {"cell.capacity_ah", "Ah", 0.1, 1000, kRequired, at<&Car::cell, &CellParameters::capacity_ah>,
    "capacity of one cell of the file"},
  {"cell.voltage_min_v", "V", 0, 5, kRequired, at<&Car::cell, &CellParameters::voltage_min_v>,
    "lowest cell voltage allowed"},
  {"cell.voltage_max_v", "V", 0, 5, kRequired, at<&Car::cell, &CellParameters::voltage_max_v>,
    "highest cell voltage allowed"},
  {"cell.mass_kg", "kg", 0.001, 100, kRequired, at<&Car::cell, &CellParameters::mass_kg>, "mass of one cell"},
  {"cell.heat_capacity_j_per_kg_k", "J/kg/K", 100, 5000, kRequired,
    at<&Car::cell, &CellParameters::heat_capacity_j_per_kg_k>,
    "heat capacity of the cell"},
  {"cell.surface_area_m2", "m2", 1e-4, 10, kRequired, at<&Car::cell, &CellParameters::surface_area_m2>,
    "cooled surface of the cell"},
  {"cell.convection_w_per_m2_k", "W/m2/K", 0, 1000, kRequired, at<&Car::cell, &CellParameters::convection_w_per_m2_k>,
    "heat transfer from cell to air"},
  {"cell.surface_lag_s", "s", 0, 600, kOptional, at<&Car::cell, &CellParameters::surface_lag_s>,
    "first-order lag by which a thermistor on the cell's surface follows the cell"},
  {"cell.reference_temperature_c", "degC", -40, 80, kRequired, at<&Car::cell, &CellParameters::reference_temperature_c>,
    "temperature at which the curves hold"},
  {"cell.reference_current_a", "A", 0, 5000, kRequired, at<&Car::cell, &CellParameters::reference_current_a>,
    "current at which the curves hold"},
  {"cell.breakpoints.soc", "1", 0, 1, kRequired, at<&Car::cell, &CellParameters::soc_breakpoints>,
    "SOC of the table points, increasing"},
  {"cell.breakpoints.temperature_c", "degC", -60, 120, kRequired,
    at<&Car::cell, &CellParameters::temperature_breakpoints_c>,
    "temperatures of the table points, increasing"},
  {"cell.breakpoints.current_a", "A", -5000, 5000, kRequired, at<&Car::cell, &CellParameters::current_breakpoints_a>,
    "currents of the table points, increasing"},
  {"cell.breakpoints.kinetic_law", "-", 0, 0, kOptional, at<&Car::cell, &CellParameters::kinetic_law>,
    "between the points by Arrhenius and Butler-Volmer instead of straight lines; true or false"},
  {"cell.ocv.polynomial_v", "V", -1e6, 1e6, kOptional, at<&Car::cell, &CellParameters::ocv_polynomial_v>,
    "open-circuit voltage: coefficients of SOC^0, SOC^1, ..."},
  {"cell.ocv.soc", "1", 0, 1, kOptional, at<&Car::cell, &CellParameters::ocv_soc>,
    "SOC of the open-circuit voltage points, increasing"},
  {"cell.ocv.voltage_v", "V", 0, 5, kOptional, at<&Car::cell, &CellParameters::ocv_v>,
    "open-circuit voltage at those points"},
  {"cell.ocv.table", "V", 0, 5, kOptional, at<&Car::cell, &CellParameters::ocv_table_v>,
    "open-circuit voltage as each test found it [soc][temperature][current]; only `validate` looks at it"},
  {"cell.r0.value", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r0_ohm, &CellParameterMap::value>,
    "series resistance by SOC, at the reference point"},
  {"cell.r0.per_kelvin", "1/K", -0.2, 0.2, kOptional, map<&CellParameters::r0_ohm, &CellParameterMap::per_kelvin>,
    "relative change of it per kelvin"},
  {"cell.r0.per_ampere", "1/A", -0.1, 0.1, kOptional, map<&CellParameters::r0_ohm, &CellParameterMap::per_ampere>,
    "relative change of it per ampere"},
  {"cell.r0.activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::r0_ohm, &CellParameterMap::activation_energy_j_per_mol>,
    "fall of it with temperature by Arrhenius"},
  {"cell.r0.exchange_current_a", "A", 0, 1e6, kOptional,
    map<&CellParameters::r0_ohm, &CellParameterMap::exchange_current_a>,
    "exchange current of a charge transfer besides the value, Butler-Volmer; 0: none"},
  {"cell.r0.exchange_activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::r0_ohm, &CellParameterMap::exchange_activation_energy_j_per_mol>,
    "rise of the exchange current with temperature by Arrhenius"},
  {"cell.r0.table", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r0_ohm, &CellParameterMap::table>,
    "series resistance by SOC, temperature and current (last fastest)"},
  {"cell.r1.value", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r1_ohm, &CellParameterMap::value>,
    "resistance of the fast branch by SOC, at the reference point"},
  {"cell.r1.per_kelvin", "1/K", -0.2, 0.2, kOptional, map<&CellParameters::r1_ohm, &CellParameterMap::per_kelvin>,
    "relative change of it per kelvin"},
  {"cell.r1.per_ampere", "1/A", -0.1, 0.1, kOptional, map<&CellParameters::r1_ohm, &CellParameterMap::per_ampere>,
    "relative change of it per ampere"},
  {"cell.r1.activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::r1_ohm, &CellParameterMap::activation_energy_j_per_mol>,
    "fall of it with temperature by Arrhenius"},
  {"cell.r1.table", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r1_ohm, &CellParameterMap::table>,
    "resistance of the fast branch by SOC, temperature and current (last fastest)"},
  {"cell.r2.value", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r2_ohm, &CellParameterMap::value>,
    "resistance of the slow branch by SOC, at the reference point"},
  {"cell.r2.per_kelvin", "1/K", -0.2, 0.2, kOptional, map<&CellParameters::r2_ohm, &CellParameterMap::per_kelvin>,
    "relative change of it per kelvin"},
  {"cell.r2.per_ampere", "1/A", -0.1, 0.1, kOptional, map<&CellParameters::r2_ohm, &CellParameterMap::per_ampere>,
    "relative change of it per ampere"},
  {"cell.r2.activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::r2_ohm, &CellParameterMap::activation_energy_j_per_mol>,
    "fall of it with temperature by Arrhenius"},
  {"cell.r2.table", "ohm", 1e-7, 10, kOptional, map<&CellParameters::r2_ohm, &CellParameterMap::table>,
    "resistance of the slow branch by SOC, temperature and current (last fastest)"},
  {"cell.tau1.value", "s", 1e-3, 1e5, kOptional, map<&CellParameters::tau1_s, &CellParameterMap::value>,
    "time constant of the fast branch by SOC, at the reference point"},
  {"cell.tau1.per_kelvin", "1/K", -0.2, 0.2, kOptional, map<&CellParameters::tau1_s, &CellParameterMap::per_kelvin>,
    "relative change of it per kelvin"},
  {"cell.tau1.per_ampere", "1/A", -0.1, 0.1, kOptional, map<&CellParameters::tau1_s, &CellParameterMap::per_ampere>,
    "relative change of it per ampere"},
  {"cell.tau1.activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::tau1_s, &CellParameterMap::activation_energy_j_per_mol>,
    "fall of it with temperature by Arrhenius"},
  {"cell.tau1.table", "s", 1e-3, 1e5, kOptional, map<&CellParameters::tau1_s, &CellParameterMap::table>,
    "time constant of the fast branch by SOC, temperature and current (last fastest)"},
  {"cell.tau2.value", "s", 1e-3, 1e5, kOptional, map<&CellParameters::tau2_s, &CellParameterMap::value>,
    "time constant of the slow branch by SOC, at the reference point"},
  {"cell.tau2.per_kelvin", "1/K", -0.2, 0.2, kOptional, map<&CellParameters::tau2_s, &CellParameterMap::per_kelvin>,
    "relative change of it per kelvin"},
  {"cell.tau2.per_ampere", "1/A", -0.1, 0.1, kOptional, map<&CellParameters::tau2_s, &CellParameterMap::per_ampere>,
    "relative change of it per ampere"},
  {"cell.tau2.activation_energy_j_per_mol", "J/mol", -200000, 200000, kOptional,
    map<&CellParameters::tau2_s, &CellParameterMap::activation_energy_j_per_mol>,
    "fall of it with temperature by Arrhenius"},
  {"cell.tau2.table", "s", 1e-3, 1e5, kOptional, map<&CellParameters::tau2_s, &CellParameterMap::table>,
    "time constant of the slow branch by SOC, temperature and current (last fastest)"},
  {"cell.effects.series_ohm", "ohm", -1, 1, kOptional, map<&CellParameters::effects, &CellEffects::series_ohm>,
    "series resistance beyond the tables"},
  {"cell.effects.activation_energy_j_per_mol", "J/mol", -60000, 60000, kOptional,
    map<&CellParameters::effects, &CellEffects::activation_energy_j_per_mol>,
    "change of all resistances with temperature beyond the tables"},
  {"cell.effects.low_end_change", "1", -0.9, 20, kOptional, map<&CellParameters::effects, &CellEffects::low_end_change>,
    "relative change of all resistances at SOC 0, fading to none at SOC 0.3"},
  {"cell.effects.exchange_current_change", "1", -0.9, 20, kOptional,
    map<&CellParameters::effects, &CellEffects::exchange_current_change>,
    "relative change of the exchange current that bends R0 over the current"},
  {"cell.effects.ocv_change_v", "V", -1, 1, kOptional, map<&CellParameters::effects, &CellEffects::ocv_change_v>,
    "added to the open-circuit voltage at equal steps of SOC from 0 to 1"},
  {"cell.effects.polarization_ohm", "ohm", -1, 1, kOptional,
    map<&CellParameters::effects, &CellEffects::polarization_ohm>,
    "resistance of one branch more"},
  {"cell.effects.polarization_tau_s", "s", 0.01, 100000, kOptional,
    map<&CellParameters::effects, &CellEffects::polarization_tau_s>,
    "its time constant"},
  {"cell.effects.slow_relaxation_ohm", "ohm", -1, 1, kOptional,
    map<&CellParameters::effects, &CellEffects::slow_relaxation_ohm>,
    "resistance of a slow branch more"},
  {"cell.effects.slow_relaxation_tau_s", "s", 0.01, 100000, kOptional,
    map<&CellParameters::effects, &CellEffects::slow_relaxation_tau_s>,
    "its time constant"},
  {"cell.effects.hysteresis_v", "V", -0.5, 0.5, kOptional, map<&CellParameters::effects, &CellEffects::hysteresis_v>,
    "rest voltage after charge or discharge against the open-circuit voltage"},
  {"cell.effects.hysteresis_per_soc", "1", 0.1, 1000, kOptional,
    map<&CellParameters::effects, &CellEffects::hysteresis_per_soc>,
    "how fast a change of direction turns the hysteresis"},
  {"cell.effects.entropy_v_per_k", "V/K", -0.01, 0.01, kOptional,
    map<&CellParameters::effects, &CellEffects::entropy_v_per_k>,
    "change of the open-circuit voltage with temperature, and its reversible heat"},
};
// clang-format on

template <auto Field>
void put(VehicleParameters& car, std::size_t index, double value) {
  if (car.battery.cells.size() <= index) car.battery.cells.resize(index + 1);
  car.battery.cells[index].*Field = value;
}
template <auto Field>
std::optional<double> get(const VehicleParameters& car, std::size_t index) {
  if (index >= car.battery.cells.size()) return std::nullopt;
  return car.battery.cells[index].*Field;
}
template <auto Field>
constexpr IndexedRow cell(std::string_view field, std::string_view unit, double low, double high,
                          std::string_view words) {
  return {"battery.cells", field, unit, low, high, put<Field>, get<Field>, words};
}

constexpr IndexedRow kVariationRows[] = {
    cell<&CellVariation::capacity_scale>("capacity_scale", "1", 0.1, 2, "factor on this cell's capacity"),
    cell<&CellVariation::resistance_scale>("resistance_scale", "1", 0.1, 10, "factor on this cell's R0, R1 and R2"),
    cell<&CellVariation::initial_soc_offset>("initial_soc_offset", "1", -1, 1, "added to this cell's initial SOC"),
    cell<&CellVariation::leak_a>("leak_a", "A", -10, 10, "current drawn inside this cell all the time"),
};

}  // namespace

std::span<const ParameterRow> cell_parameter_rows() { return kRows; }
std::span<const IndexedRow> cell_variation_rows() { return kVariationRows; }

}  // namespace voltlap::plant
