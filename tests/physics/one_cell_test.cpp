// SPDX-License-Identifier: Apache-2.0
// Pack, identify, validate and explain make the same of one cell's current: voltage, SOC, heat and temperatures, to
// rounding error, for drawn cells of 1 to 4 branches and drawn currents.
#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "car/battery/pack.hpp"
#include "explain/balances/battery_response.hpp"
#include "learn/identify/circuit/circuit_model.hpp"
#include "learn/validate/cell_response.hpp"
#include "plant_sim/fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

using Eigen::Index;

constexpr double kStep = 0.5;       // s
constexpr double kFullSoc = 0.95;
constexpr double kRounding = 1e-10;  // V, 1, K; of sums over some hundred steps

/// What one of the callers makes of the cell, row by row. A column that it does not make is empty.
struct Trace {
  std::string caller;
  std::vector<double> voltage_v, soc, temperature_c, surface_c;
};

/// A cell whose circuit is the same everywhere, so that it does not matter when tables are read; OCV straight over SOC.
CellParameters drawn_cell(std::mt19937_64& random, bool with_effects) {
  const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random); };
  CellParameters out = constant_cell();
  out.capacity_ah = between(2.0, 40.0);
  out.mass_kg = between(0.05, 1.0);
  out.heat_capacity_j_per_kg_k = between(700.0, 1200.0);
  out.surface_area_m2 = between(0.005, 0.05);
  out.convection_w_per_m2_k = between(0.0, 1.0) < 0.2 ? 0.0 : between(3.0, 30.0);
  out.surface_lag_s = between(0.0, 1.0) < 0.3 ? 0.0 : between(5.0, 60.0);
  out.soc_breakpoints = {0.0, 1.0};
  out.temperature_breakpoints_c = {25.0};
  out.current_breakpoints_a = {10.0};
  out.kinetic_law = false;
  out.ocv_polynomial_v = {between(2.8, 3.2), between(0.3, 1.2)};
  out.ocv_soc.clear();
  out.ocv_v.clear();
  const auto everywhere = [](CellParameterMap& map, double value) { map = {{value, value}, 0.0, 0.0, {}}; };
  everywhere(out.r0_ohm, between(0.5e-3, 2e-2));
  out.branches = {};
  const auto count = std::uniform_int_distribution<std::size_t>(1, kMostCellBranches)(random);
  double slowest = between(0.3, 20.0);
  for (std::size_t k = 0; k < count; ++k) {
    everywhere(out.branches[k].r_ohm, between(0.2e-3, 1e-2));
    everywhere(out.branches[k].tau_s, slowest);
    slowest *= between(2.0, 8.0);
  }
  out.effects = {};
  if (!with_effects) return out;
  out.effects.series_ohm = between(0.0, 2e-3);
  out.effects.polarization_ohm = between(0.0, 3e-3);
  out.effects.polarization_tau_s = between(0.5, 5.0);
  out.effects.slow_relaxation_ohm = between(0.0, 3e-3);
  out.effects.slow_relaxation_tau_s = between(200.0, 900.0);
  out.effects.hysteresis_v = between(0.0, 0.02);
  out.effects.hysteresis_per_soc = between(5.0, 40.0);
  out.effects.entropy_v_per_k = between(-4e-4, 4e-4);
  return out;
}

/// Steps of current with rests and charges between them, constant from row to row.
std::vector<double> drawn_current(std::mt19937_64& random, double capacity_ah) {
  std::vector<double> out{0.0};
  while (out.size() < 400) {
    const double rate = std::uniform_real_distribution(-1.0, 4.0)(random);
    const std::size_t rows = std::uniform_int_distribution<std::size_t>(1, 40)(random);
    out.insert(out.end(), rows, std::abs(rate) < 0.3 ? 0.0 : rate * capacity_ah);
  }
  return out;
}

VehicleParameters car_of(const CellParameters& cell) {
  VehicleParameters out = vtm16e();
  out.cell = cell;
  out.battery.cells_in_series = out.battery.cells_in_parallel = 1;
  out.battery.initial_soc = kFullSoc;
  out.battery.initial_temperature_c = out.environment.ambient_c = 21.0;
  out.battery.contact_resistance_ohm = 0.0;
  out.battery.cells.clear();
  return out;
}

MeasuredRun run_of(const std::vector<double>& current_a, const CellParameters& cell) {
  CellLog log;
  for (std::size_t row = 0; row < current_a.size(); ++row) log.time_s.push_back(kStep * static_cast<double>(row));
  log.current_a = current_a;
  log.voltage_v.assign(current_a.size(), 3.5);
  log.gap.assign(current_a.size(), false);
  RunOptions options;
  options.hold = CurrentHold::kNext;
  options.capacity_ah = cell.capacity_ah;
  options.anchor = {0, kFullSoc, "drawn"};
  return make_run(log, options);
}

std::vector<double> list_of(const Eigen::VectorXd& values) { return {values.begin(), values.end()}; }

Trace by_pack(const CellParameters& cell, const std::vector<double>& current_a) {
  const VehicleParameters car = car_of(cell);
  Pack pack(car, false, kStep);
  Trace out{"pack", {pack.cell_voltage(0)}, {pack.cell_soc(0)}, {21.0}, {21.0}};
  for (std::size_t row = 1; row < current_a.size(); ++row) {
    pack.advance(current_a[row]);
    out.voltage_v.push_back(pack.cell_voltage_after_step(0));
    out.soc.push_back(pack.cell_soc(0));
    pack.renew(kStep, car.environment.ambient_c);
    out.temperature_c.push_back(pack.cell_temperature_c(0));
    out.surface_c.push_back(pack.surface_temperature_c(0));
  }
  return out;
}

Trace by_identify(const CellParameters& cell, const std::vector<double>& current_a) {
  const MeasuredRun run = run_of(current_a, cell);
  CircuitModel model;
  model.capacity_ah = cell.capacity_ah;
  model.em.resize(model.ocv.size());
  for (Index k = 0; k < model.ocv.size(); ++k) {
    model.em(k) = cell.ocv_polynomial_v[0] + cell.ocv_polynomial_v[1] * model.ocv.at(k);
  }
  const Eigen::VectorXd everywhere = Eigen::VectorXd::Ones(model.grid.size());
  const std::size_t branches = cell.branch_count();
  model.r.resize(model.grid.size(), static_cast<Index>(branches) + 1);
  model.tau.resize(model.grid.size(), static_cast<Index>(branches));
  model.r.col(0) = everywhere * cell.r0_ohm.value[0];
  for (std::size_t k = 0; k < branches; ++k) {
    model.r.col(static_cast<Index>(k) + 1) = everywhere * cell.branches[k].r_ohm.value[0];
    model.tau.col(static_cast<Index>(k)) = everywhere * cell.branches[k].tau_s.value[0];
  }
  return {"identify", list_of(simulate(model, run)), list_of(run.soc), {}, {}};
}

Trace by_validate(const CellParameters& cell, const std::vector<double>& current_a) {
  const MeasuredRun run = run_of(current_a, cell);
  CellLog log;
  log.ambient_c.assign(current_a.size(), 21.0);
  const CellResponse response = respond(CellModel(cell), run, RecordedTemperature(log, 21.0));
  return {"validate", list_of(response.voltage), list_of(run.soc), {}, list_of(response.temperature)};
}

Trace by_explain(const CellParameters& cell, const std::vector<double>& current_a) {
  World world;
  world.car = car_of(cell);
  Recording log;
  const MeasuredRun run = run_of(current_a, cell);
  log.time_s = run.time_s;
  LogFacts facts;
  facts.hold = CurrentHold::kNext;
  facts.initial_soc = kFullSoc;
  facts.initial_temperature_c = 21.0;
  facts.current_a = run.current_a;
  facts.stopped.assign(current_a.size(), false);
  const BatteryResponse response = battery_response(world, log, facts);
  return {"explain", list_of(response.voltage_v), list_of(response.soc), list_of(response.temperature_c),
          list_of(response.surface_c)};
}

double largest_difference(const std::vector<double>& one, const std::vector<double>& other) {
  if (one.empty() || other.empty()) return 0.0;
  if (one.size() != other.size()) return INFINITY;
  double out = 0.0;
  for (std::size_t k = 0; k < one.size(); ++k) {
    const double apart = std::abs(one[k] - other[k]);
    if (!(apart <= out)) out = std::isnan(apart) ? INFINITY : apart;
  }
  return out;
}

/// Callers whose cell is another than the pack's, with the column.
std::string disagreements(const std::vector<Trace>& traces) {
  std::string out;
  for (const Trace& trace : traces) {
    const auto hold = [&](const char* what, const std::vector<double>& theirs, const std::vector<double>& packs) {
      if (largest_difference(theirs, packs) > kRounding) out += trace.caller + " " + what + " ";
    };
    hold("voltage", trace.voltage_v, traces[0].voltage_v);
    hold("soc", trace.soc, traces[0].soc);
    hold("temperature", trace.temperature_c, traces[0].temperature_c);
    hold("surface", trace.surface_c, traces[0].surface_c);
  }
  return out;
}

/// identify's circuit has no effects beyond its branches: it is asked only without them.
std::vector<Trace> traces_of(const CellParameters& cell, const std::vector<double>& current_a, bool with_effects) {
  std::vector<Trace> out{by_pack(cell, current_a)};
  if (!with_effects) out.push_back(by_identify(cell, current_a));
  out.push_back(by_validate(cell, current_a));
  out.push_back(by_explain(cell, current_a));
  return out;
}

std::uint64_t seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? std::strtoull(given, nullptr, 10) : std::random_device{}();
}

}  // namespace

TEST_GROUP(OneCell) {
  const std::uint64_t drawn = seed();
  std::mt19937_64 random{drawn};

  void check(bool with_effects) {
    for (int trial = 0; trial < 40; ++trial) {
      const CellParameters cell = drawn_cell(random, with_effects);
      const std::vector<Trace> traces = traces_of(cell, drawn_current(random, cell.capacity_ah), with_effects);
      const std::string found = disagreements(traces);
      if (found.empty()) continue;
      FAIL(("VOLTLAP_TEST_SEED=" + std::to_string(drawn) + ", trial " + std::to_string(trial) + ": " + found).c_str());
    }
  }
};

TEST(OneCell, AllFourCallersMakeTheSameOfACurrent) { check(false); }

TEST(OneCell, WithEveryEffectPackValidationAndExplanationMakeTheSame) { check(true); }

TEST(OneCell, APlantedDifferenceInEachCallerIsSeen) {
  const CellParameters cell = drawn_cell(random, false);
  const std::vector<double> current_a = drawn_current(random, cell.capacity_ah);
  CellParameters other = cell;
  for (double& r : other.branches[0].r_ohm.value) r *= 1.00001;
  const std::vector<Trace> right = traces_of(cell, current_a, false), wrong = traces_of(other, current_a, false);
  STRCMP_EQUAL("", disagreements(right).c_str());
  for (std::size_t caller = 0; caller < right.size(); ++caller) {
    std::vector<Trace> mixed = right;
    mixed[caller] = wrong[caller];
    // One that differs from the pack is named; where the pack itself differs, all others are.
    const std::string named = caller == 0 ? "identify voltage" : right[caller].caller + " voltage";
    STRCMP_CONTAINS(named.c_str(), disagreements(mixed).c_str());
  }
}

TEST(OneCell, APlantedDifferenceInSocHeatOrSurfaceIsSeen) {
  const CellParameters cell = drawn_cell(random, false);
  const std::vector<double> current_a = drawn_current(random, cell.capacity_ah);
  const std::vector<Trace> right = traces_of(cell, current_a, false);
  for (std::size_t caller = 1; caller < right.size(); ++caller) {
    std::vector<Trace> wrong = right;
    wrong[caller].soc[200] += 1e-9;
    STRCMP_CONTAINS((right[caller].caller + " soc").c_str(), disagreements(wrong).c_str());
    if (right[caller].surface_c.empty()) continue;
    wrong[caller].surface_c[200] += 1e-9;
    STRCMP_CONTAINS((right[caller].caller + " surface").c_str(), disagreements(wrong).c_str());
  }
}
