// SPDX-License-Identifier: Apache-2.0
#include "car/battery/pack.hpp"

#include <algorithm>
#include <cmath>

#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kPeriod_s = 0.01;

/// Steps of `step_s` at constant current, tables renewed every control period.
void apply(Pack& pack, double current_a, double seconds, double step_s) {
  const auto per_period = std::max(1L, std::lround(kPeriod_s / step_s));
  const auto steps = std::lround(seconds / step_s);
  for (long i = 1; i <= steps; ++i) {
    pack.advance(current_a);
    if (i % per_period == 0) pack.renew(static_cast<double>(per_period) * step_s, 26.85);
  }
}

/// Mean over [t, t + dt] of 1 - exp(-t / tau): response of an RC branch to a current step at 0, over R I.
double mean_rise(double t, double dt, double tau) {
  return 1.0 - tau / dt * (std::exp(-t / tau) - std::exp(-(t + dt) / tau));
}

}  // namespace

TEST_GROUP(Pack) {
  VehicleParameters car = vtm16e();
  VehicleParameters constant = vtm16e();

  void setup() override {
    constant.cell = constant_cell();
    constant.battery.initial_soc = 0.5;
  }
};

TEST(Pack, VoltageIsTheMeanOfTheStepAlsoWhereTheChargeLowersTheOcv) {
  constant.cell.ocv_polynomial_v = {3.0, 1.2};
  constexpr double kCurrent = 200.0, kPulse = 60.0;
  for (const double step : {0.01, 0.1, 1.0}) {
    Pack pack(constant, true, step);
    const PackThevenin before = pack.thevenin();
    pack.advance(kCurrent);
    DOUBLES_EQUAL(before.voltage_v - before.resistance_ohm * kCurrent, pack.voltage(), 1e-9);
    apply(pack, kCurrent, kPulse - step, step);
    const double soc = 0.5 - kCurrent * (kPulse - 0.5 * step) / 3600.0 / constant.cell.capacity_ah;
    const double expected = 3.0 + 1.2 * soc - kCurrent * (0.0012 + 0.0004 * mean_rise(kPulse - step, step, 33.0) +
                                                          0.0008 * mean_rise(kPulse - step, step, 161.0));
    DOUBLES_EQUAL(expected, pack.cell_voltage(0), 1e-9);
  }
}

TEST(Pack, PulseFollowsTheAnalyticResponseAtEveryStep) {
  constexpr double kCurrent = 200.0, kPulse = 60.0;
  for (const double step : {0.001, 0.01, 0.1, 1.0}) {
    Pack pack(constant, true, step);
    apply(pack, kCurrent, kPulse, step);
    const double in_pulse = 3.7 - kCurrent * (0.0012 + 0.0004 * mean_rise(kPulse - step, step, 33.0) +
                                              0.0008 * mean_rise(kPulse - step, step, 161.0));
    DOUBLES_EQUAL(in_pulse, pack.cell_voltage(0), 1e-9);

    apply(pack, 0.0, 30.0, step);  // relaxation: the branches discharge from where the pulse left them
    const auto fall = [&](double tau) {
      return (1.0 - std::exp(-kPulse / tau)) * (1.0 - mean_rise(30.0 - step, step, tau));
    };
    DOUBLES_EQUAL(3.7 - kCurrent * (0.0004 * fall(33.0) + 0.0008 * fall(161.0)), pack.cell_voltage(0), 1e-9);
  }
}

TEST(Pack, APulseFollowsTheAnalyticResponseOfOneToFourBranches) {
  constexpr double kCurrent = 200.0, kPulse = 60.0, kStep = 0.1;
  const std::vector<std::pair<double, double>> all{{3e-4, 0.7}, {4e-4, 9.0}, {6e-4, 80.0}, {9e-4, 1500.0}};
  constant.cell.branches = {};
  double expected = 3.7 - kCurrent * 0.0012;
  for (std::size_t k = 0; k < all.size(); ++k) {
    const auto& [ohm, tau_s] = all[k];
    constant.cell.branches[k] = {{{ohm}, 0.0, 0.0, {}}, {{tau_s}, 0.0, 0.0, {}}};
    expected -= kCurrent * ohm * mean_rise(kPulse - kStep, kStep, tau_s);
    Pack one(constant, true, kStep), each(constant, false, kStep);
    for (Pack* pack : {&one, &each}) {
      apply(*pack, kCurrent, kPulse, kStep);
      DOUBLES_EQUAL(expected, pack->cell_voltage(0), 1e-9);
    }
  }
}

TEST(Pack, TheEnergyOfOneToFourBranchesIsHeatStoreAndTerminal) {
  constexpr double kStep = 0.5;
  CellBranch branch = car.cell.branches[0];
  for (std::size_t count = 1; count <= kMostCellBranches; ++count) {
    car.cell.branches[count - 1] = branch;
    for (std::size_t k = count; k < kMostCellBranches; ++k) car.cell.branches[k] = {};
    for (double& tau : branch.tau_s.value) tau *= 4.0;
    Pack pack(car, false, kStep);
    PackEnergy sum;
    double terminal_j = 0.0;
    for (int step = 0; step < 600; ++step) {
      const double current = step % 50 < 30 ? 180.0 : -60.0;
      const PackEnergy energy = pack.advance(current);
      sum.chemical_j += energy.chemical_j;
      sum.r0_heat_j += energy.r0_heat_j;
      sum.rc_heat_j += energy.rc_heat_j;
      sum.rc_stored_j += energy.rc_stored_j;
      terminal_j += pack.voltage() * current * kStep;
      pack.renew(kStep, 25.0);
    }
    DOUBLES_EQUAL(sum.chemical_j, sum.r0_heat_j + sum.rc_heat_j + sum.rc_stored_j + terminal_j, 1e-9 * sum.chemical_j);
    CHECK(sum.rc_heat_j > 0.0);
  }
}

TEST(Pack, ContactTakesItsDropFromThePackAndItsHeatFromNoCell) {
  constexpr double kStep = 0.01, kCurrent = 200.0, kContact = 0.006;
  Pack without(constant, false, kStep);
  constant.battery.contact_resistance_ohm = kContact;
  Pack with(constant, false, kStep);
  DOUBLES_EQUAL(kContact, with.thevenin().resistance_ohm - without.thevenin().resistance_ohm, 1e-12);
  const PackEnergy a = without.advance(kCurrent), b = with.advance(kCurrent);
  DOUBLES_EQUAL(kContact * kCurrent, without.voltage() - with.voltage(), 1e-9);
  DOUBLES_EQUAL(kContact * kCurrent * kCurrent * kStep, b.r0_heat_j - a.r0_heat_j, 1e-9);
  DOUBLES_EQUAL(b.chemical_j, b.r0_heat_j + b.rc_heat_j + b.rc_stored_j + with.voltage() * kCurrent * kStep, 1e-6);
  DOUBLES_EQUAL(without.cell_voltage(3), with.cell_voltage(3), 0.0);
  without.renew(kStep, 26.85);
  with.renew(kStep, 26.85);
  DOUBLES_EQUAL(without.cell_temperature_c(3), with.cell_temperature_c(3), 0.0);
}

TEST(Pack, OpenCircuitVoltageMinusBranchesMinusOhmicDropIsTheTerminalVoltage) {
  // An independent cell: the same tables, Euler steps a hundred times finer.
  constexpr double kStep = 0.001;
  constexpr int kFine = 100;
  Pack pack(car, true, kStep);
  const CellTables tables(car.cell);
  double soc = 1.0, v1 = 0.0, v2 = 0.0, worst = 0.0;
  for (int period = 0; period < 500; ++period) {
    const double current = 150.0 + 150.0 * std::sin(0.05 * period) - (period > 300 ? 180.0 : 0.0);
    const CircuitParameters p = tables.circuit(pack.cell_soc(0), pack.cell_temperature_c(0), pack.lookup_current_a());
    for (int step = 0; step < 10; ++step) {
      double sum = 0.0;
      const double ocv = tables.ocv(soc - 0.5 * current * kStep / 3600.0 / 55.2).voltage_v;
      for (int fine = 0; fine < kFine; ++fine) {
        const double d1 = (p.r_ohm[0] * current - v1) / p.tau_s[0] * kStep / kFine;
        const double d2 = (p.r_ohm[1] * current - v2) / p.tau_s[1] * kStep / kFine;
        sum += ocv - (v1 + 0.5 * d1) - (v2 + 0.5 * d2) - p.r0_ohm * current;
        v1 += d1;
        v2 += d2;
      }
      soc -= current * kStep / 3600.0 / 55.2;
      pack.advance(current);
      worst = std::max(worst, std::abs(pack.cell_voltage(0) - sum / kFine));
    }
    pack.renew(kPeriod_s, 26.85);
  }
  DOUBLES_EQUAL(0.0, worst, 1e-7);
  DOUBLES_EQUAL(soc, pack.cell_soc(0), 1e-12);
}

TEST(Pack, TheveninPredictsTheVoltageOfTheComingStep) {
  for (const int parallel : {1, 2}) {
    for (const bool representative : {true, false}) {
      car.battery.cells_in_parallel = parallel;
      Pack pack(car, representative, 0.001);
      for (int i = 0; i < 300; ++i) {
        const double current = 220.0 * std::sin(0.1 * i) + 50.0;
        const PackThevenin source = pack.thevenin();
        pack.advance(current);
        DOUBLES_EQUAL(source.voltage_v - source.resistance_ohm * current, pack.voltage(), 1e-10);
        if (i % 10 == 9) pack.renew(kPeriod_s, 26.85);
      }
    }
  }
}

TEST(Pack, AFreshPackRestsAtItsOpenCircuitVoltage) {
  Pack pack(car, false, 0.001);
  DOUBLES_EQUAL(24.0 * 4.17, pack.voltage(), 1e-6);
  DOUBLES_EQUAL(4.17, pack.cell_voltage(23), 1e-7);
  DOUBLES_EQUAL(1.0, pack.soc_mean(), 0.0);
}

TEST(Pack, LookupKeepsTheLastCurrentAboveTheFloor) {
  Pack pack(car, true, 0.001);
  pack.advance(120.0);
  DOUBLES_EQUAL(120.0, pack.lookup_current_a(), 0.0);
  for (const double small : {0.0, 4.9, 5.0, -5.0}) {
    pack.advance(small);
    DOUBLES_EQUAL(120.0, pack.lookup_current_a(), 0.0);
  }
  pack.advance(-5.1);
  DOUBLES_EQUAL(5.1, pack.lookup_current_a(), 0.0);
}

TEST(Pack, ResistanceOfARestingCellStaysThatOfTheLastLoad) {
  Pack pack(car, true, 0.001);
  pack.advance(300.0);
  pack.renew(kPeriod_s, 26.85);
  const double loaded = pack.thevenin().resistance_ohm;
  pack.advance(0.0);
  pack.renew(kPeriod_s, 26.85);
  DOUBLES_EQUAL(loaded, pack.thevenin().resistance_ohm, 1e-6 * loaded);
}

TEST(Pack, ChargingRaisesVoltageAndStateOfChargeAndStillHeats) {
  car.battery.initial_soc = 0.5;
  Pack pack(car, false, 0.001);
  const double rest = pack.voltage();
  apply(pack, -100.0, 10.0, 0.001);
  CHECK(pack.voltage() > rest);
  DOUBLES_EQUAL(0.5 + 1000.0 / 3600.0 / 55.2, pack.soc_mean(), 1e-12);
  CHECK(pack.temperature_max_c() > 26.85);
  DOUBLES_EQUAL(-1000.0 / 3600.0, pack.charge_out_ah(), 1e-10);
}

TEST(Pack, AFullPackHasBeenChargedAndItsHysteresisStandsThere) {
  constexpr double kSize_v = 0.02;
  car.cell.effects.hysteresis_v = kSize_v;
  const auto above_ocv = [&](double soc) {
    car.battery.initial_soc = soc;
    Pack pack(car, false, 0.001);
    pack.advance(0.0);
    return pack.cell_voltage_after_step(0) - CellTables(car.cell).ocv_v(soc, car.battery.initial_temperature_c);
  };
  DOUBLES_EQUAL(kSize_v, above_ocv(1.0), 1e-6);
  DOUBLES_EQUAL(0.0, above_ocv(0.6), 1e-6);
}

TEST(Pack, ARepresentativeCellStandsForEqualCells) {
  Pack one(car, true, 0.001), all(car, false, 0.001);
  for (int i = 0; i < 2000; ++i) {
    const PackEnergy a = one.advance(180.0), b = all.advance(180.0);
    DOUBLES_EQUAL(a.chemical_j, b.chemical_j, 1e-9 * b.chemical_j);
    DOUBLES_EQUAL(a.rc_heat_j, b.rc_heat_j, 1e-9);
    if (i % 10 == 9) {
      one.renew(kPeriod_s, 26.85);
      all.renew(kPeriod_s, 26.85);
    }
  }
  DOUBLES_EQUAL(one.voltage(), all.voltage(), 1e-9);
  DOUBLES_EQUAL(one.soc_mean(), all.soc_mean(), 1e-12);
  DOUBLES_EQUAL(one.temperature_max_c(), all.temperature_max_c(), 1e-12);
}

TEST(Pack, TwoCellsInParallelShareTheCurrent) {
  Pack single(car, true, 0.001);
  car.battery.cells_in_parallel = 2;
  Pack pair(car, true, 0.001);
  apply(single, 100.0, 20.0, 0.001);
  apply(pair, 200.0, 20.0, 0.001);
  DOUBLES_EQUAL(single.voltage(), pair.voltage(), 1e-9);
  DOUBLES_EQUAL(single.soc_mean(), pair.soc_mean(), 1e-12);
  DOUBLES_EQUAL(single.thevenin().resistance_ohm / 2.0, pair.thevenin().resistance_ohm, 1e-12);
  DOUBLES_EQUAL(2.0 * single.advance(100.0).r0_heat_j, pair.advance(200.0).r0_heat_j, 1e-9);
}

TEST(Pack, ASmallerCellEmptiesFasterAndIsTheWeakest) {
  car.battery.cells.resize(7);
  car.battery.cells[6].capacity_scale = 0.92;
  Pack pack(car, false, 0.001);
  apply(pack, 200.0, 60.0, 0.001);
  DOUBLES_EQUAL((1.0 - pack.cell_soc(0)) / 0.92, 1.0 - pack.cell_soc(6), 1e-12);
  LONGS_EQUAL(6, pack.weakest_cell());
  DOUBLES_EQUAL(pack.cell_voltage(6), pack.cell_voltage_min(), 0.0);
  DOUBLES_EQUAL(0.92 * 55.2, pack.capacity_ah(6), 1e-9);
}

TEST(Pack, ACellOfMoreResistanceIsLowerUnderLoadAndHotter) {
  car.battery.cells.resize(24);
  car.battery.cells[2].resistance_scale = 1.5;
  car.battery.cells[9].initial_soc_offset = -0.1;
  Pack pack(car, false, 0.001);
  DOUBLES_EQUAL(0.9, pack.cell_soc(9), 1e-12);
  apply(pack, 300.0, 20.0, 0.001);
  CHECK(pack.cell_voltage(2) < pack.cell_voltage(1));
  CHECK(pack.cell_temperature_c(2) > pack.cell_temperature_c(1));
}

TEST(Pack, CellsThatDifferRefuseARepresentativeCell) {
  car.battery.cells.resize(1);
  car.battery.cells[0].resistance_scale = 1.1;
  STRCMP_CONTAINS("--cells all", input_error([this] { Pack pack(car, true, 0.001); }).c_str());
}

TEST(Pack, ACellBeyondTheLastIsRefusedByItsNumber) {
  car.battery.cells.resize(25);
  STRCMP_CONTAINS("battery.cells.25: found a cell that the pack does not have; expected a cell from 1 to 24",
                  input_error([this] { Pack pack(car, false, 0.001); }).c_str());
}

TEST(Pack, WithoutCoolingAllHeatOfTheResistancesWarmsTheCells) {
  constant.cell.convection_w_per_m2_k = 0.0;
  Pack pack(constant, false, 0.01);
  double heat = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const PackEnergy e = pack.advance(250.0);
    heat += e.r0_heat_j + e.rc_heat_j;
    pack.renew(0.01, 26.85);
  }
  DOUBLES_EQUAL(heat / 24.0 / (1.9 * 747.0), pack.temperature_max_c() - 26.85, 1e-9);
}

TEST(Pack, AHotCellCoolsExponentiallyToAmbient) {
  constant.battery.initial_temperature_c = 46.85;
  Pack pack(constant, true, 0.01);
  const double tau = 1.9 * 747.0 / (7.0 * 0.152);
  for (int i = 0; i < 60000; ++i) {
    pack.advance(0.0);
    pack.renew(0.01, 26.85);
  }
  DOUBLES_EQUAL(26.85 + 20.0 * std::exp(-600.0 / tau), pack.temperature_max_c(), 1e-9);
}

TEST(Pack, SteadyLoadSettlesWhereCoolingBalancesTheHeat) {
  constant.battery.initial_temperature_c = 26.85;
  Pack pack(constant, true, 1.0);
  for (int i = 0; i < 40000; ++i) {  // capacity does not matter to a flat OCV
    pack.advance(100.0);
    pack.renew(1.0, 26.85);
  }
  const double heat_w = 100.0 * 100.0 * (0.0012 + 0.0004 + 0.0008);
  DOUBLES_EQUAL(26.85 + heat_w / (7.0 * 0.152), pack.temperature_max_c(), 1e-6);
}

TEST(Pack, TheOpenCircuitVoltageFollowsTheTemperatureByTheEntropy) {
  car.cell.effects.entropy_v_per_k = 2e-4;
  const auto at_rest = [&](double temperature_c) {
    car.battery.initial_temperature_c = temperature_c;
    return Pack(car, true, 0.001).voltage();
  };
  const double reference_c = car.cell.reference_temperature_c;
  DOUBLES_EQUAL(2e-4 * 15.0 * car.battery.cells_in_series, at_rest(reference_c + 15.0) - at_rest(reference_c), 1e-9);
}

TEST(Pack, TheSurfaceOfACellThatWarmsSteadilyIsItsLagBehind) {
  constexpr double kLag = 40.0;
  constant.cell.convection_w_per_m2_k = 0.0;
  constant.cell.surface_lag_s = kLag;
  Pack pack(constant, true, 1.0);
  const auto minute = [&] {
    for (int i = 0; i < 60; ++i) {
      pack.advance(100.0);
      pack.renew(1.0, 26.85);
    }
    return pack.cell_temperature_c(0);
  };
  for (int i = 0; i < 20; ++i) (void)minute();
  const double before = pack.cell_temperature_c(0), rate = (minute() - before) / 60.0;
  // The branches still warm up.
  DOUBLES_EQUAL(kLag * rate, pack.cell_temperature_c(0) - pack.surface_temperature_c(0), 1e-4);
}

TEST(Pack, WithoutALagTheSurfaceIsAsWarmAsTheCell) {
  Pack pack(constant, false, 0.01);
  apply(pack, 200.0, 30.0, 0.01);
  CHECK(pack.cell_temperature_c(3) > 26.9);
  DOUBLES_EQUAL(pack.cell_temperature_c(3), pack.surface_temperature_c(3), 0.0);
}

TEST(Pack, AShuntTakesTheCellsVoltageOverItsResistanceAndItsReadingSags) {
  constant.cell.ocv_polynomial_v = {4.0};
  constant.battery.balancing_resistance_ohm = 39.5;
  constant.battery.sense_resistance_ohm = 0.5;
  Pack pack(constant, false, 0.01);
  pack.set_bleeding({3});
  apply(pack, 0.0, 3600.0, 0.1);
  const double capacity_ah = pack.capacity_ah(3);
  DOUBLES_EQUAL(0.5 - 0.1 * pack.bleed_charge_c() / 360.0 / capacity_ah, pack.cell_soc(3), 1e-9);
  DOUBLES_EQUAL(360.0, pack.bleed_charge_c() * 10.0, 1e-6);  // 0.1 A; steps of 0.01 s, a tenth of the time
  DOUBLES_EQUAL(4.0 * pack.bleed_charge_c(), pack.bleed_energy_j(), 1e-6);
  DOUBLES_EQUAL(0.5, pack.cell_soc(4), 0.0);
  DOUBLES_EQUAL(4.0, pack.cell_voltage(3), 1e-9);
  DOUBLES_EQUAL(4.0 - 0.1 * (0.5 + 0.0012), pack.read_voltage(3), 1e-4);
  DOUBLES_EQUAL(4.0, pack.read_voltage(4), 1e-9);
  pack.set_bleeding({});
  DOUBLES_EQUAL(4.0, pack.read_voltage(3), 1e-9);
}
