// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/virtual_bench.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "bench_fixtures.hpp"
#include "fixtures.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

constexpr double kR0 = 0.0012, kR1 = 0.0004, kR2 = 0.0008, kTau1 = 33.0, kTau2 = 161.0;  // of constant_cell()

/// One cell of constant_cell() on a quarter of the load's resistance, by Runge and Kutta: independent of the plant.
struct Circuit {
  double v1 = 0.0, v2 = 0.0;
  [[nodiscard]] double current(double ohm) const { return (3.7 - v1 - v2) / (kR0 + ohm / 4.0); }
  void advance(double ohm, double seconds) {
    constexpr double kStep = 0.0025;
    for (long i = std::lround(seconds / kStep); i > 0; --i) {
      const auto slope = [&](double a, double b) {
        const double current = (3.7 - a - b) / (kR0 + ohm / 4.0);
        return std::pair{(kR1 * current - a) / kTau1, (kR2 * current - b) / kTau2};
      };
      const auto [a1, b1] = slope(v1, v2);
      const auto [a2, b2] = slope(v1 + 0.5 * kStep * a1, v2 + 0.5 * kStep * b1);
      v1 += kStep * a2;
      v2 += kStep * b2;
    }
  }
};

/// Mean of a minute minus the mean of the minute before it, of V = a exp(-t / tau) rising to its rest.
double rise_seen(double a, double tau, double t) {
  const double grown = std::exp(60.0 / tau) - 1.0;
  return a * tau / 60.0 * grown * grown * std::exp(-t / tau);
}

const BenchPhase& first_of(const BenchRecord& record, bool load) {
  const auto found = std::find_if(record.phases.begin(), record.phases.end(),
                                  [&](const BenchPhase& s) { return s.load == load && s.begin_s > 0.0; });
  CHECK(found != record.phases.end());
  return *found;
}

std::size_t row_at(const BenchRecord& record, double time_s) {
  return static_cast<std::size_t>(std::lower_bound(record.time_s.begin(), record.time_s.end(), time_s - 1e-9) -
                                  record.time_s.begin());
}

/// A plan with one pulse through four resistors of the high bank.
BenchPlan one_pulse(const std::vector<std::string>& more) {
  std::vector<std::string> settings = {"load.resistors=[4]",
                                       "schedule.pulse_s=120",
                                       "test.initial_rest_s=10",
                                       "instruments.noise=false",
                                       "instruments.quantisation=false",
                                       "instruments.systematic=false",
                                       "cells.capacity_spread=0",
                                       "cells.resistance_spread=0",
                                       "cells.soc_spread=0",
                                       "box.mode=bath",
                                       "sampling.log_hz=8"};
  settings.insert(settings.end(), more.begin(), more.end());
  return shipped_plan("random_resistors", settings);
}

}  // namespace

TEST_GROUP(VirtualBench) {
  static void check_charge(const BenchRecord& record, double capacity_ah) {
    double logged = 0.0;
    for (const double current : record.true_current_a) logged += current / 8.0 / 3600.0;
    DOUBLES_EQUAL(record.charge_ah, logged, 1e-9 * logged);
    for (const CellRecord& cell : record.cells) {
      DOUBLES_EQUAL(record.charge_ah, (cell.initial_soc - cell.true_soc.back()) * capacity_ah, 1e-9 * record.charge_ah);
    }
  }
};

TEST(VirtualBench, CurrentThroughAResistorIsThatOfTheClosedCircuitAtEveryReading) {
  const BenchRecord record = run_equal(one_pulse({}), constant_cell());
  constexpr double kLoad = 0.3 / 4.0, kReading = 0.125;
  Circuit circuit;
  DOUBLES_EQUAL(4.0 * 3.7 / (4.0 * kR0 + kLoad), circuit.current(kLoad), 1e-9);
  for (std::size_t row = row_at(record, 10.0); row < row_at(record, 130.0); ++row) {
    circuit.advance(kLoad, 0.5 * kReading);
    DOUBLES_EQUAL(circuit.current(kLoad), record.true_current_a[row], 1e-4);
    DOUBLES_EQUAL(record.true_current_a[row] * kLoad, 4.0 * record.cells[0].true_voltage_v[row], 1e-9);
    circuit.advance(kLoad, 0.5 * kReading);
  }
}

TEST(VirtualBench, ACellDoesNotKnowHowOftenItIsRead) {
  // Low charge, where OCV and time constants are steep, and currents that jump from pulse to pulse.
  const std::vector<std::string> settings = {"load.resistors=[4, 8, 2]", "schedule.pulse_s=40", "rest.seconds=50",
                                             "cells.initial_soc=0.25", "sampling.log_hz=1"};
  std::vector<std::string> finely = settings;
  finely.push_back("sampling.rate_hz=64");
  const BenchRecord seldom = run_equal(one_pulse(settings), vtm16e().cell);
  const BenchRecord often = run_equal(one_pulse(finely), vtm16e().cell);
  LONGS_EQUAL(often.time_s.size(), seldom.time_s.size());
  double voltage = 0.0, current = 0.0;
  for (std::size_t row = 0; row < often.time_s.size(); ++row) {
    voltage = std::max(voltage, std::abs(often.cells[0].true_voltage_v[row] - seldom.cells[0].true_voltage_v[row]));
    current = std::max(current, std::abs(often.true_current_a[row] - seldom.true_current_a[row]));
  }
  CHECK_TEXT(voltage < 5e-6, std::to_string(1e6 * voltage).c_str());  // a hundredth of a row's noise
  CHECK_TEXT(current < 1e-3, std::to_string(1e3 * current).c_str());
}

TEST(VirtualBench, RelaxationEndsWhenTheDecayOfAKnownCellSaysSo) {
  const BenchRecord record = run_equal(one_pulse({"rest.rule=relaxed"}), constant_cell());
  Circuit circuit;
  circuit.advance(0.3 / 4.0, 120.0);
  double expected = 120.0;
  while (rise_seen(circuit.v1, kTau1, expected) + rise_seen(circuit.v2, kTau2, expected) > 0.001) expected += 0.01;
  const BenchPhase& rest = record.phases.back();
  CHECK_FALSE(rest.load);
  DOUBLES_EQUAL(expected, rest.end_s - rest.begin_s, 0.3);
}

TEST(VirtualBench, FixedRestLastsAsLongAsThePlanSays) {
  const BenchRecord record = run_equal(one_pulse({}), constant_cell());
  DOUBLES_EQUAL(150.0, record.phases.back().end_s - record.phases.back().begin_s, 1e-9);
  DOUBLES_EQUAL(280.0, record.duration_s(), 1e-9);
}

TEST(VirtualBench, RestThatNeverSettlesEndsAtItsLimit) {
  const BenchRecord record =
      run_equal(one_pulse({"rest.rule=relaxed", "rest.max_s=200", "rest.rise_v_per_min=1e-6"}), constant_cell());
  DOUBLES_EQUAL(200.0, record.phases.back().end_s - record.phases.back().begin_s, 1e-9);
}

TEST(VirtualBench, ChargeThatIsCountedIsTheCapacityThatTheCellsLost) {
  check_charge(run_equal(ideal_plan(), vtm16e().cell), 55.2);
  check_charge(run_equal(ideal_plan({"load.kind=cycler"}), straight_cell()), 55.2);
}

TEST(VirtualBench, FirstReadingAt2500MillivoltsUnderLoadEndsTheTestAndIsNamed) {
  BenchPlan plan = ideal_plan();
  const BenchRecord record =
      run_bench_test(plan, tests_of(plan).front(), {vtm16e().cell, {{}, {0.9, 1.0, 0.0}, {}, {}}, false},
                     draw_errors(plan.instruments, 4, 1), 1);
  CHECK(record.end == TestEnd::kVoltage);
  LONGS_EQUAL(2, record.end_cell);
  const BenchPhase& last_load = record.phases[record.phases.size() - 2];
  CHECK(last_load.load);
  const std::vector<double>& voltage = record.cells[1].voltage_v;
  const std::size_t last = row_at(record, last_load.end_s) - 1;
  CHECK(voltage[last] <= 2.5);
  CHECK(*std::min_element(voltage.begin(), voltage.begin() + static_cast<std::ptrdiff_t>(last)) > 2.5);
  CHECK(*std::min_element(record.cells[0].voltage_v.begin(), record.cells[0].voltage_v.end()) > 2.5);
}

TEST(VirtualBench, RestAfterTheLastPulseIsRecordedToItsEnd) {
  const BenchRecord record = run_equal(ideal_plan(), vtm16e().cell);
  CHECK_FALSE(record.phases.back().load);
  CHECK(record.phases.back().end_s - record.phases.back().begin_s >= 120.0);
  DOUBLES_EQUAL(record.duration_s(), record.time_s.back() + 0.125, 1e-9);
}

TEST(VirtualBench, PulsesLastAsLongAsEquation51SaysToWithinAReading) {
  const BenchRecord record = run_equal(ideal_plan({"load.kind=cycler"}), vtm16e().cell);
  const double capacity = 55.0 - 5.0 * (200.0 - 35.0) / 365.0;
  std::vector<double> lengths;
  for (const BenchPhase& phase : record.phases) {
    if (phase.load) lengths.push_back(phase.end_s - phase.begin_s);
  }
  CHECK(lengths.size() > 14);
  for (std::size_t i = 0; i + 1 < lengths.size(); ++i) {
    const double step = i >= 4 && i < 10 ? 0.1 : 0.05;
    DOUBLES_EQUAL(3600.0 * capacity * step / 200.0, lengths[i], 0.0626);
  }
}

TEST(VirtualBench, ARowIsTheMeanOfItsReadingsOrTheFirstOfThem) {
  const BenchRecord all = run_equal(one_pulse({}), constant_cell());
  const BenchRecord mean = run_equal(one_pulse({"sampling.log_hz=1"}), constant_cell());
  const BenchRecord first = run_equal(one_pulse({"sampling.log_hz=1", "sampling.resample=first"}), constant_cell());
  const std::size_t row = row_at(all, 20.0);
  double sum = 0.0;
  for (std::size_t i = 0; i < 8; ++i) sum += all.cells[0].voltage_v[row + i];
  DOUBLES_EQUAL(20.0, mean.time_s[20], 1e-9);
  DOUBLES_EQUAL(sum / 8.0, mean.cells[0].voltage_v[20], 1e-12);
  DOUBLES_EQUAL(all.cells[0].voltage_v[row], first.cells[0].voltage_v[20], 1e-12);
}

TEST(VirtualBench, CellsInABathKeepTheirTemperatureAndFreeOnesWarmUp) {
  const BenchRecord bath = run_equal(ideal_plan(), vtm16e().cell);
  const BenchRecord free = run_equal(ideal_plan({"box.mode=free"}), vtm16e().cell);
  const auto hottest = [](const BenchRecord& record) {
    const auto& t = record.cells[0].true_temperature_c;
    return *std::max_element(t.begin(), t.end());
  };
  DOUBLES_EQUAL(30.0, hottest(bath), 1e-3);
  CHECK(hottest(free) > 31.0);
}

TEST(VirtualBench, PulsesOfAControlledBoxBeginWithEveryThermistorInTheBand) {
  const BenchRecord record =
      run_equal(ideal_plan({"box.mode=controlled", "box.band_k=0.5", "test.current_a=400"}), vtm16e().cell);
  std::size_t pulses = 0;
  for (const BenchPhase& phase : record.phases) {
    if (!phase.load || phase.begin_s == 0.0) continue;
    DOUBLES_EQUAL(30.0, record.cells[3].temperature_c[row_at(record, phase.begin_s) - 1], 0.5);
    ++pulses;
  }
  CHECK(pulses > 14);
}

TEST(VirtualBench, HotCellEndsTheTest) {
  const BenchRecord record =
      run_equal(ideal_plan({"box.mode=free", "stop.cell_temperature_max_c=31"}), vtm16e().cell);
  CHECK(record.end == TestEnd::kTemperature);
  CHECK(record.charge_ah < 50.0);
}

TEST(VirtualBench, ChargePulseEndsAtTheHighestVoltageAndTheTestGoesOn) {
  BenchPlan plan = shipped_plan("hppc", {"stop.cell_voltage_max_v=3.9", "instruments.noise=false",
                                         "sampling.log_hz=10", "rest.seconds=60", "schedule.set_current_a=100"});
  const BenchRecord record = run_equal(plan, vtm16e().cell);
  CHECK(record.end == TestEnd::kVoltage);
  const auto charge = std::find_if(record.phases.begin(), record.phases.end(),
                                   [](const BenchPhase& s) { return s.charge_ah < 0.0; });
  CHECK(charge != record.phases.end());
  CHECK(charge->end_s - charge->begin_s < 9.9);
}

TEST(VirtualBench, ACellThatNeverEmptiesIsAnError) {
  const std::string message = input_error([] {
    (void)run_equal(ideal_plan({"rest.rule=fixed", "rest.seconds=1"}), constant_cell());
  });
  STRCMP_CONTAINS("30c_200a", message.c_str());
  STRCMP_CONTAINS("no cell at 2.5 V", message.c_str());
}

TEST(VirtualBench, SystematicErrorIsInTheTableAndNotInTheTruth) {
  BenchPlan plan = one_pulse({});
  InstrumentErrors errors = draw_errors(plan.instruments, 4, 1);
  errors.cell_offset_v[1] = 0.004;
  errors.current_high_gain = 0.01;
  errors.current_high_offset_a = 2.0;
  const BenchRecord record = run_bench_test(plan, tests_of(plan).front(),
                                           {constant_cell(), std::vector<CellVariation>(4), false}, errors, 1);
  const std::size_t row = row_at(record, 60.0);
  DOUBLES_EQUAL(record.cells[1].true_voltage_v[row] + 0.004, record.cells[1].voltage_v[row], 1e-12);
  DOUBLES_EQUAL(record.cells[0].true_voltage_v[row], record.cells[0].voltage_v[row], 1e-12);
  DOUBLES_EQUAL(1.01 * record.true_current_a[row] + 2.0, record.current_a[row], 1e-9);
}

TEST(VirtualBench, StopRequestEndsTheTestWithinASimulatedMinute) {
  const BenchPlan plan = ideal_plan();
  const BenchRecord record =
      run_bench_test(plan, tests_of(plan).front(), {straight_cell(), std::vector<CellVariation>(4), false},
                     draw_errors(plan.instruments, 4, 1), 1, [](double time_s) { return time_s > 600.0; });
  CHECK(record.end == TestEnd::kInterrupted);
  DOUBLES_EQUAL(660.0, record.duration_s(), 1e-9);
}

TEST(VirtualBench, FirstStretchIsTheRestOfThePlan) {
  const BenchRecord record = run_equal(ideal_plan(), vtm16e().cell);
  DOUBLES_EQUAL(60.0, first_of(record, true).begin_s, 1e-9);
  DOUBLES_EQUAL(4.17, record.cells[0].voltage_v.front(), 1e-6);
}
