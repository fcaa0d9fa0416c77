// SPDX-License-Identifier: Apache-2.0
#include "car/battery/cell_tables.hpp"

#include <array>
#include <cmath>

#include "car/battery/cell_effects.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

/// The curve form of one parameter, written out as a full table.
std::vector<double> as_table(const CellParameters& cell, const CellParameterMap& map) {
  std::vector<double> table;
  for (const double value : map.value) {
    for (const double t : cell.temperature_breakpoints_c) {
      for (const double i : cell.current_breakpoints_a) {
        table.push_back(value * (1.0 + map.per_kelvin * (t - cell.reference_temperature_c)) *
                        (1.0 + map.per_ampere * (i - cell.reference_current_a)));
      }
    }
  }
  return table;
}

double ocv_polynomial(double s) {
  return 3.00 + s * (5.98 + s * (-14.1 + s * (15.2 + s * (-6.79 + s * 0.88))));
}

void check_mentions(const std::string& message, const char* part) {
  STRCMP_CONTAINS(part, message.c_str());
}

}  // namespace

TEST_GROUP(CellTables) {
  CellParameters cell = vtm16e().cell;

  std::string refusal() const {
    return input_error([this] { CellTables tables(cell); });
  }
};

TEST(CellTables, ReferencePointGivesTheCurveItself) {
  const CircuitParameters p = CellTables(cell).circuit(0.5, 30.0, 200.0);
  DOUBLES_EQUAL(0.0012, p.r0_ohm, 1e-12);
  DOUBLES_EQUAL(0.0004, p.r_ohm[0], 1e-12);
  DOUBLES_EQUAL(0.0008, p.r_ohm[1], 1e-12);
  DOUBLES_EQUAL(64.5, p.tau_s[0], 1e-9);
  DOUBLES_EQUAL(616.5, p.tau_s[1], 1e-9);
}

TEST(CellTables, ColdCellHasMoreResistanceAndHighCurrentLess) {
  const CellTables tables(cell);
  DOUBLES_EQUAL(0.0012 * (1.0 + 0.014 * 8.0), tables.circuit(0.5, 22.0, 200.0).r0_ohm, 1e-12);
  DOUBLES_EQUAL(0.0012 * (1.0 - 0.00034 * 200.0), tables.circuit(0.5, 30.0, 400.0).r0_ohm, 1e-12);
}

TEST(CellTables, LookupIsTrilinearBetweenBreakpoints) {
  cell.soc_breakpoints = {0.0, 1.0};
  cell.temperature_breakpoints_c = {20.0, 40.0};
  cell.current_breakpoints_a = {0.0, 100.0};
  const std::vector<double> corners = {1, 2, 3, 5, 7, 11, 13, 17};
  for (auto* map : maps_of(cell)) *map = {{}, 0, 0, corners};
  const double s = 0.3, t = 0.6, i = 0.25;
  double expected = 0.0;
  for (std::size_t n = 0; n < 8; ++n) {
    expected += corners[n] * ((n & 4U) != 0 ? s : 1 - s) * ((n & 2U) != 0 ? t : 1 - t) * ((n & 1U) != 0 ? i : 1 - i);
  }
  DOUBLES_EQUAL(expected, CellTables(cell).circuit(s, 20.0 + 20.0 * t, 100.0 * i).r0_ohm, 1e-12);
}

TEST(CellTables, ACurveWithLawsFollowsThemBetweenAndBeyondItsPoints) {
  constexpr double kOhmic = 18e3, kBranch = 30e3, kExchange_a = 40.0;
  cell.temperature_breakpoints_c = {-20.0, -15.0, -10.0, -5.0, 0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0};
  cell.current_breakpoints_a = {5.0, 20.0, 50.0, 100.0};
  cell.reference_temperature_c = 25.0;
  cell.kinetic_law = true;
  const double r0 = 1.2e-3, r1 = 0.9e-3, tau1 = 20.0;
  cell.r0_ohm = cell.branches[0].r_ohm = cell.branches[0].tau_s = {};
  cell.r0_ohm.value.assign(cell.soc_breakpoints.size(), r0);
  cell.branches[0].r_ohm.value.assign(cell.soc_breakpoints.size(), r1);
  cell.branches[0].tau_s.value.assign(cell.soc_breakpoints.size(), tau1);
  cell.r0_ohm.activation_energy_j_per_mol = kOhmic;
  cell.r0_ohm.exchange_current_a = kExchange_a;
  cell.r0_ohm.exchange_activation_energy_j_per_mol = kBranch;
  for (std::size_t k = 0; k < 2; ++k) {
    cell.branches[k].r_ohm.per_kelvin = cell.branches[k].r_ohm.per_ampere = 0.0;
    cell.branches[k].r_ohm.activation_energy_j_per_mol = kBranch;
  }
  cell.branches[0].tau_s.activation_energy_j_per_mol = 5e3;
  const CellTables tables(cell);
  const auto factor = [](double energy, double c) {
    return std::exp(energy / 8.314462618 * (1.0 / (c + 273.15) - 1.0 / 298.15));
  };
  for (double c = -25.0; c <= 45.0; c += 3.3) {
    for (double i = 1.0; i <= 140.0; i *= 1.7) {
      const double exchange = kExchange_a / factor(kBranch, c), thermal_v = 8.314462618 * (c + 273.15) / 96485.33212;
      const double transfer = 4.0 * thermal_v * std::asinh(0.5 * i / exchange) / i;
      const CircuitParameters p = tables.circuit(0.5, c, i);
      const bool inside = c >= -20.0 && c <= 40.0 && i >= 5.0 && i <= 100.0;
      DOUBLES_EQUAL(1.0, p.r0_ohm / (r0 * factor(kOhmic, c) + transfer), inside ? 4e-3 : 2e-2);
      DOUBLES_EQUAL(1.0, p.r_ohm[0] / (r1 * factor(kBranch, c)), 5e-3);
      DOUBLES_EQUAL(1.0, p.tau_s[0] / (tau1 * factor(5e3, c)), 5e-3);
    }
  }
}

TEST(CellTables, KineticsSayWhatIsBetweenTestsAtThreeTemperaturesAndRates) {
  // Ohms and a charge transfer of two electrodes, both by Arrhenius; known at nine points, asked between them.
  const auto arrhenius = [](double energy, double c) {
    return std::exp(energy / 8.314 * (1.0 / (c + 273.15) - 1.0 / 298.15));
  };
  const auto truth = [&](double c, double i) {
    const double exchange = 40.0 / arrhenius(30e3, c);
    return 1.2e-3 * arrhenius(12e3, c) + charge_transfer_v(exchange, i, c) / i;
  };
  const std::vector<double> temperatures = {12.0, 25.0, 40.0}, currents = {15.0, 45.0, 120.0};
  cell.soc_breakpoints = {0.0, 1.0};
  cell.temperature_breakpoints_c = temperatures;
  cell.current_breakpoints_a = currents;
  std::vector<double> r0, slow, fast, tau;
  for (int soc = 0; soc < 2; ++soc) {
    for (const double c : temperatures) {
      for (const double i : currents) {
        r0.push_back(truth(c, i));
        const double share = c > 20.0 ? 0.2 : 0.7;  // the same lag, divided otherwise
        fast.push_back(share * 2e-3 * arrhenius(20e3, c));
        slow.push_back((1.0 - share) * 2e-3 * arrhenius(20e3, c));
        tau.push_back(20.0);
      }
    }
  }
  cell.r0_ohm = {{}, 0, 0, r0};
  cell.branches[0].r_ohm = {{}, 0, 0, fast};
  cell.branches[1].r_ohm = {{}, 0, 0, slow};
  cell.branches[0].tau_s = cell.branches[1].tau_s = {{}, 0, 0, tau};
  const CellTables straight(cell);
  cell.kinetic_law = true;
  const CellTables kinetic(cell);
  double worst_straight = 0.0, worst = 0.0, worst_beyond = 0.0;
  for (double c = 5.0; c <= 48.0; c += 1.7) {
    for (double i = 2.0; i <= 170.0; i *= 1.3) {
      const CircuitParameters p = kinetic.circuit(0.5, c, i);
      const double error = std::abs(p.r0_ohm / truth(c, i) - 1.0);
      DOUBLES_EQUAL(1.0, (p.r_ohm[0] + p.r_ohm[1]) / (2e-3 * arrhenius(20e3, c)), 2e-3);
      const bool inside = c >= 12.0 && c <= 40.0 && i >= 15.0 && i <= 120.0;
      worst_beyond = std::max(worst_beyond, error);
      if (!inside) continue;
      worst = std::max(worst, error);
      worst_straight = std::max(worst_straight, std::abs(straight.circuit(0.5, c, i).r0_ohm / truth(c, i) - 1.0));
    }
  }
  CHECK(worst < 4e-3);
  CHECK(worst_beyond < 2e-2);  // 7 K colder, 8 K warmer, 1.4 times the largest current
  CHECK(worst_straight > 2e-2);
  for (const double c : temperatures) DOUBLES_EQUAL(truth(c, 45.0), kinetic.circuit(0.5, c, 45.0).r0_ohm, 1e-12);
}

TEST(CellTables, OutsideTheBreakpointsTheEndValuesHold) {
  const CellTables tables(cell);
  DOUBLES_EQUAL(tables.circuit(0.001, 22.0, 35.0).r_ohm[0], tables.circuit(-0.2, -10.0, 0.0).r_ohm[0], 1e-15);
  DOUBLES_EQUAL(tables.circuit(1.0, 40.0, 400.0).tau_s[1], tables.circuit(1.3, 90.0, 4000.0).tau_s[1], 1e-9);
}

TEST(CellTables, EachOfOneToFourBranchesHasItsOwnTables) {
  const CellBranch first = cell.branches[0];
  cell.branches = {};
  for (std::size_t count = 1; count <= kMostCellBranches; ++count) {
    CellBranch& last = cell.branches[count - 1];
    last = first;
    for (double& r : last.r_ohm.value) r *= static_cast<double>(count);
    for (double& tau : last.tau_s.value) tau *= std::pow(5.0, static_cast<double>(count));
    const CellTables tables(cell);
    LONGS_EQUAL(count, tables.branches());
    const CircuitParameters p = tables.circuit(0.5, 30.0, 200.0);
    DOUBLES_EQUAL(0.0012, p.r0_ohm, 1e-12);
    for (std::size_t k = 0; k < kMostCellBranches; ++k) {
      DOUBLES_EQUAL(k < count ? 0.0004 * static_cast<double>(k + 1) : 0.0, p.r_ohm[k], 1e-12);
      DOUBLES_EQUAL(k < count ? 64.5 * std::pow(5.0, static_cast<double>(k + 1)) : 0.0, p.tau_s[k], 1e-7);
    }
  }
}

TEST(CellTables, KineticsActOnTheSumOfAllBranches) {
  // Two temperatures whose lags are divided in other ways; the sum of three branches follows one activation energy.
  constexpr double kEnergy = 40000.0, kSum = 2e-3;
  const auto sum_at = [](double c) {
    return kSum * std::exp(kEnergy / kGasConstant * (1.0 / (c + kZeroCelsius) - 1.0 / (25.0 + kZeroCelsius)));
  };
  const std::array<double, 3> cold{0.5, 0.2, 0.3}, warm{0.1, 0.6, 0.3};
  cell.soc_breakpoints = {0.0, 1.0};
  cell.temperature_breakpoints_c = {10.0, 25.0};
  cell.current_breakpoints_a = {30.0};
  cell.kinetic_law = true;
  cell.branches = {};
  cell.r0_ohm = {{}, 0.0, 0.0, {1e-3, 1e-3, 1e-3, 1e-3}};
  for (std::size_t k = 0; k < 3; ++k) {
    const double at_cold = cold[k] * sum_at(10.0), at_warm = warm[k] * sum_at(25.0);
    const double tau = std::pow(10.0, static_cast<double>(k));
    cell.branches[k] = {{{}, 0.0, 0.0, {at_cold, at_warm, at_cold, at_warm}}, {{}, 0.0, 0.0, {tau, tau, tau, tau}}};
  }
  const CellTables tables(cell);
  for (const double c : {10.0, 12.0, 17.0, 22.5, 25.0, 33.0}) {
    const CircuitParameters p = tables.circuit(0.5, c, 30.0);
    DOUBLES_EQUAL(sum_at(c), total_ohm(p) - p.r0_ohm, 2e-3 * sum_at(c));
    DOUBLES_EQUAL(100.0, p.tau_s[2], 1e-9);
  }
}

TEST(CellTables, TableFormGivesTheSameNumbersAsTheCurveForm) {
  CellParameters full = cell;
  for (CellParameterMap* map : maps_of(full)) *map = {{}, 0.0, 0.0, as_table(cell, *map)};
  const CellTables curve(cell), table(full);
  for (const double soc : {0.0, 0.07, 0.33, 0.62, 1.0}) {
    const CircuitParameters a = curve.circuit(soc, 27.3, 160.0), b = table.circuit(soc, 27.3, 160.0);
    DOUBLES_EQUAL(a.r0_ohm, b.r0_ohm, 1e-15);
    DOUBLES_EQUAL(a.tau_s[0], b.tau_s[0], 1e-12);
    DOUBLES_EQUAL(a.tau_s[1], b.tau_s[1], 1e-12);
  }
}

TEST(CellTables, OneBreakpointOnEveryAxisIsAConstantCell) {
  const CellTables tables(constant_cell());
  for (const double x : {-1.0, 0.5, 2.0}) {
    const CircuitParameters p = tables.circuit(x, 50.0 * x, 300.0 * x);
    DOUBLES_EQUAL(0.0012, p.r0_ohm, 1e-15);
    DOUBLES_EQUAL(161.0, p.tau_s[1], 1e-12);
  }
}

TEST(CellTables, OpenCircuitVoltageFollowsThePolynomial) {
  const CellTables tables(cell);
  for (double soc = 0.0; soc <= 1.0; soc += 0.0137) DOUBLES_EQUAL(ocv_polynomial(soc), tables.ocv(soc).voltage_v, 1e-5);
  DOUBLES_EQUAL(4.17, tables.ocv(1.0).voltage_v, 1e-9);
}

TEST(CellTables, TabulatedOpenCircuitVoltageAgreesWithThePolynomial) {
  CellParameters tabulated = cell;
  tabulated.ocv_polynomial_v.clear();
  for (int i = 0; i <= 200; ++i) {
    tabulated.ocv_soc.push_back(i / 200.0);
    tabulated.ocv_v.push_back(ocv_polynomial(i / 200.0));
  }
  const CellTables a(cell), b(tabulated);
  for (double soc = 0.0; soc <= 1.0; soc += 0.0137) DOUBLES_EQUAL(a.ocv(soc).voltage_v, b.ocv(soc).voltage_v, 2e-4);
}

TEST(CellTables, LevelStretchOfTheOcvIsNoFall) {
  CellParameters level = cell;
  level.ocv_polynomial_v.clear();
  level.ocv_soc = {0.0, 0.266667, 0.283333, 1.0};
  for (const double volts : {3.99445, 3.99463, 4.1454}) {
    level.ocv_v = {3.9, volts, volts, 4.2};
    DOUBLES_EQUAL(volts, CellTables(level).ocv(0.275).voltage_v, 1e-9);
  }
}

TEST(CellTables, SlopeOfTheOcvIsItsDerivative) {
  const CellTables tables(cell);
  for (const double soc : {0.0504, 0.3004, 0.7004}) {
    const double rise = tables.ocv(soc + 1e-4).voltage_v - tables.ocv(soc - 1e-4).voltage_v;
    DOUBLES_EQUAL(rise / 2e-4, tables.ocv(soc).slope_v, 1e-6);
  }
}

TEST(CellTables, StateOfChargeOfAVoltageInvertsTheOcv) {
  const CellTables tables(cell);
  for (double soc = 0.0; soc <= 1.0; soc += 0.0137) {
    DOUBLES_EQUAL(soc, tables.soc_of_ocv(tables.ocv(soc).voltage_v, 25.0), 1e-9);
  }
  CellParameters warm = cell;
  warm.reference_temperature_c = 30.0;
  warm.effects.entropy_v_per_k = 4e-4;
  const CellTables entropic(warm);
  DOUBLES_EQUAL(tables.ocv(0.5).voltage_v + 4e-3, entropic.ocv_v(0.5, 40.0), 1e-12);
  DOUBLES_EQUAL(0.5, entropic.soc_of_ocv(entropic.ocv_v(0.5, 40.0), 40.0), 1e-9);
  DOUBLES_EQUAL(0.0, tables.soc_of_ocv(1.0, 25.0), 0.0);
  DOUBLES_EQUAL(1.0, tables.soc_of_ocv(5.0, 25.0), 0.0);
}

TEST(CellTables, BreakpointsThatDoNotIncreaseAreRefusedByName) {
  cell.temperature_breakpoints_c = {22.0, 22.0, 40.0};
  check_mentions(refusal(), "breakpoints.temperature_c: found");
}

TEST(CellTables, AMapOfTheWrongSizeIsRefusedByName) {
  cell.branches[0].r_ohm.value.pop_back();
  check_mentions(refusal(), "r1.value: found 15 values; expected 16");
  cell.branches[0].r_ohm.table = {1.0, 2.0};
  check_mentions(refusal(), "r1.table: found 2 values");
}

TEST(CellTables, AResistanceOrTimeConstantThatIsNotPositiveIsRefused) {
  cell.branches[1].tau_s.value[3] = 0.0;
  check_mentions(refusal(), "tau2: found 0 at SOC 0.15");
  cell = vtm16e().cell;
  cell.r0_ohm.per_ampere = -0.01;
  check_mentions(refusal(), "r0: found");
}

TEST(CellTables, AnOcvThatFallsWithSocIsRefused) {
  cell.ocv_polynomial_v = {4.0, -0.5};
  check_mentions(refusal(), "a voltage that falls");
}

TEST(CellTables, ACellWithoutOcvIsRefused) {
  cell.ocv_polynomial_v.clear();
  check_mentions(refusal(), "no open-circuit voltage");
  cell.ocv_soc = {0.0, 1.0};
  cell.ocv_v = {3.0};
  check_mentions(refusal(), "2 values of soc and 1 of voltage_v");
}

TEST(CellTables, TheExchangeCurrentIsTheOneThatBendsTheResistanceOverTheCurrents) {
  constexpr double kOhms = 1e-3, kChange = -0.3, kWarm = 35.0;
  const auto exchange = [](double at_c) { return 12.0 * std::exp(0.05 * (at_c - 25.0)); };
  const auto with_charge_transfer = [&](double share) {
    CellParameters out = cell;
    out.soc_breakpoints = {0.5};
    out.temperature_breakpoints_c = {15.0, kWarm};
    out.current_breakpoints_a = {5.0, 20.0, 60.0};
    out.r0_ohm = {};
    out.branches = {};
    for (const double t : out.temperature_breakpoints_c) {
      for (const double i : out.current_breakpoints_a) {
        out.r0_ohm.table.push_back(kOhms + charge_transfer_v(share * exchange(t), i, t) / i);
        out.branches[0].r_ohm.table.push_back(1.0);
        out.branches[0].tau_s.table.push_back(1.0);
      }
    }
    return out;
  };
  CellParameters changed = with_charge_transfer(1.0);
  changed.effects.exchange_current_change = kChange;
  const CellTables tables(changed), expected(with_charge_transfer(1.0 + kChange)), given(with_charge_transfer(1.0));
  for (const double t : {15.0, kWarm}) {
    for (const double i : {5.0, 20.0, 60.0}) {
      const double rise = expected.circuit(0.5, t, i).r0_ohm - given.circuit(0.5, t, i).r0_ohm;
      DOUBLES_EQUAL(rise, tables.circuit(0.5, t, i).r0_ohm - given.circuit(0.5, t, i).r0_ohm, 0.03 * rise);
    }
  }
}

TEST(CellTables, WithOneCurrentTheExchangeCurrentIsWhatTheFirstBranchSays) {
  cell = constant_cell();
  const double at_c = cell.temperature_breakpoints_c.front();
  const CircuitParameters given = CellTables(cell).circuit(0.5, at_c, 1e-6);
  cell.effects.exchange_current_change = -0.5;  // twice the ohms of a small current
  DOUBLES_EQUAL(given.r_ohm[0], CellTables(cell).circuit(0.5, at_c, 1e-6).r0_ohm - given.r0_ohm, 1e-3 * given.r_ohm[0]);
}

TEST(CellTables, ATableThatBeginsAtNoCurrentSaysTheSameOfTheExchangeCurrent) {
  const auto rise = [&](std::vector<double> currents_a) {
    CellParameters changed = constant_cell();
    changed.r0_ohm = {};
    const double at_c = changed.temperature_breakpoints_c.front();
    changed.temperature_breakpoints_c = {at_c};
    changed.soc_breakpoints = {0.5};
    changed.current_breakpoints_a = currents_a;
    for (const double i : currents_a)
      changed.r0_ohm.table.push_back(1e-3 + charge_transfer_v(4.0, std::max(i, 1e-6), at_c) / std::max(i, 1e-6));
    const double given = CellTables(changed).circuit(0.5, at_c, 20.0).r0_ohm;
    changed.effects.exchange_current_change = -0.5;
    return CellTables(changed).circuit(0.5, at_c, 20.0).r0_ohm - given;
  };
  const double expected = rise({5.0, 20.0, 60.0});
  CHECK(expected > 1e-4);
  DOUBLES_EQUAL(expected, rise({0.0, 5.0, 20.0, 60.0}), 0.02 * expected);
}
