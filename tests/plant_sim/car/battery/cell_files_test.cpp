// SPDX-License-Identifier: Apache-2.0
// The cells that ship: what a discharge of each gives, beside the numbers that its class of cell is known by.
#include <cmath>
#include <string>

#include "car/battery/cell.hpp"
#include "core/parameter_file.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// What is known of a cell. Energy per mass: rated capacity times nominal voltage over mass.
struct Known {
  const char* name;
  double nominal_v, wh_per_kg, dc_ohm_low, dc_ohm_high, current_max_a;
};

constexpr Known kKnown[] = {
    {"molicel_p42a", 3.6, 216.0, 0.010, 0.022, 45.0}, {"molicel_p45b", 3.6, 232.0, 0.009, 0.020, 45.0},
    {"sony_vtc6", 3.6, 241.0, 0.016, 0.032, 30.0},    {"samsung_30q", 3.6, 225.0, 0.017, 0.034, 15.0},
    {"lg_m50lt", 3.63, 251.0, 0.022, 0.042, 14.4},    {"melasta_slpbb042126", 3.7, 190.0, 0.0025, 0.006, 99.0},
};

constexpr double kVoltageTolerance_v = 0.12;  // of the mean of a C/5 discharge to the nominal voltage
constexpr double kEnergyTolerance = 0.08;     // of a C/5 discharge to the energy of the class
constexpr double kTemperature_c = 25.0;

struct Discharge {
  double charge_ah = 0.0, energy_wh = 0.0;
  [[nodiscard]] double mean_v() const { return energy_wh / charge_ah; }
};

/// Constant current from full to the cut-off voltage at a constant temperature.
Discharge discharge(const CellParameters& parameters, double current_a) {
  const Cell cell(parameters);
  CellState state;
  state.temperature_c = kTemperature_c;
  cell.look_up(state, {current_a, state.soc, kTemperature_c});
  Discharge sum;
  const CellInterval second{1.0, current_a, current_a};
  while (state.soc > 0.0) {
    const double soc = state.soc - soc_drawn(second, parameters.capacity_ah);
    cell.advance(state, second, {current_a, soc, kTemperature_c});
    state.soc = soc;
    const double voltage = cell.tables().ocv(soc).voltage_v - cell.drop_v(state, current_a);
    if (voltage < parameters.voltage_min_v) break;
    sum.charge_ah += current_a / 3600.0;
    sum.energy_wh += voltage * current_a / 3600.0;
  }
  return sum;
}

double dc_resistance(const CellParameters& cell) {
  const CircuitParameters p = CellTables(cell).circuit(0.5, kTemperature_c, cell.reference_current_a);
  double out = p.r0_ohm;
  for (std::size_t k = 0; k < cell.branch_count(); ++k) out += p.r_ohm[k] * (1.0 - std::exp(-10.0 / p.tau_s[k]));
  return out;
}

}  // namespace

TEST_GROUP(CellFiles) {
  DataFolder data{VOLTLAP_SOURCE_DIR "/plant_sim/data"};

  CellParameters cell(const Known& known) const { return load_cell(data, known.name, "test"); }
};

TEST(CellFiles, MeanVoltageOfASlowDischargeIsTheNominalVoltage) {
  for (const Known& known : kKnown) {
    const CellParameters c = cell(known);
    DOUBLES_EQUAL_TEXT(known.nominal_v, discharge(c, 0.2 * c.capacity_ah).mean_v(), kVoltageTolerance_v, known.name);
  }
}

TEST(CellFiles, SlowDischargeGivesTheEnergyOfTheClassOfCell) {
  for (const Known& known : kKnown) {
    const CellParameters c = cell(known);
    const double density = discharge(c, 0.2 * c.capacity_ah).energy_wh / c.mass_kg;
    DOUBLES_EQUAL_TEXT(known.wh_per_kg, density, kEnergyTolerance * known.wh_per_kg, known.name);
  }
}

TEST(CellFiles, TenSecondsOfCurrentShowAResistanceOfTheClassOfCell) {
  for (const Known& known : kKnown) {
    const double ohm = dc_resistance(cell(known));
    CHECK_TEXT(ohm >= known.dc_ohm_low && ohm <= known.dc_ohm_high, known.name);
  }
}

TEST(CellFiles, MoreCurrentGivesLessVoltageAndLessCharge) {
  for (const Known& known : kKnown) {
    const CellParameters c = cell(known);
    const Discharge slow = discharge(c, c.capacity_ah), quick = discharge(c, known.current_max_a);
    CHECK_TEXT(slow.charge_ah > 0.93 * c.capacity_ah, known.name);
    CHECK_TEXT(quick.charge_ah > 0.5 * c.capacity_ah, known.name);
    CHECK_TEXT(quick.mean_v() < slow.mean_v() && quick.charge_ah < slow.charge_ah, known.name);
  }
}

TEST(CellFiles, WarmCellHasLessResistance) {
  for (const Known& known : kKnown) {
    const CellTables tables(cell(known));
    CHECK_TEXT(tables.circuit(0.5, 50.0, 5.0).r0_ohm < tables.circuit(0.5, 10.0, 5.0).r0_ohm, known.name);
  }
}
