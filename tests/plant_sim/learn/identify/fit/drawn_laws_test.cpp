// SPDX-License-Identifier: Apache-2.0
// Laws over temperature and current of drawn cells: found within their intervals, and good beyond what was tested.
#include <algorithm>
#include <cstdlib>

#include "learn/identify/cell_identification.hpp"
#include "learn/identify/circuit/fitted_circuit.hpp"
#include "plant_sim/learn/identify/laws_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(DrawnLaws) {
  std::mt19937 draw;
  unsigned seed = 1;
  void setup() override {
    if (const char* given = std::getenv("VOLTLAP_TEST_SEED")) seed = static_cast<unsigned>(std::atoi(given));
    draw.seed(seed);
  }
  SimpleString about(int k, const char* what) {
    return StringFromFormat("VOLTLAP_TEST_SEED=%u, draw %d: %s", seed, k, what);
  }

  static CellIdentification identified(const std::vector<CellLog>& logs) {
    IdentifyOptions options;
    options.branches = 2;
    options.tables = IdentifyOptions::Tables::kByLaws;
    std::vector<double> temperatures_c;
    for (const CellLog& log : logs) temperatures_c.push_back(log.temperature_c.front());
    return identify_cell(logs, temperatures_c, options);
  }
  /// Of the open-circuit voltage, narrower than any table is: the circuit is not all there is.
  static void add_ripple(CellLog & log, const LawsCell& cell, double ripple_v) {
    double drawn_as = 0.0;
    for (std::size_t row = 1; row < log.rows(); ++row) {
      drawn_as += log.current_a[row];
      log.voltage_v[row] += ripple_v * std::sin(200.0 * drawn_as / (3600.0 * cell.capacity_ah));
    }
  }
  /// RMS of a model on a recording that begins full, and of the recording's overvoltage [V].
  struct Prediction {
    double rms_v, overvoltage_v;
  };
  static Prediction predict(const CircuitModel& model, const LawsCell& cell, const CellLog& log) {
    RunOptions options;
    options.capacity_ah = model.capacity_ah;
    const MeasuredRun run = make_run(log, options);
    const Eigen::VectorXd error = simulate(model, run) - run.voltage_v;
    double square = 0.0, over = 0.0, count = 0.0;
    for (Eigen::Index row = 0; row < run.rows(); ++row) {
      const double soc = 1.0 - (1.0 - run.soc(row)) * model.capacity_ah / cell.capacity_ah;
      const double drop = LawsCell::em(soc) - run.voltage_v(row);
      square += error(row) * error(row);
      over += drop * drop;
      count += 1.0;
    }
    return {std::sqrt(square / count), std::sqrt(over / count)};
  }
};

/// The laws that a fit found less the true ones, with their deviations [kJ/mol], [mV/K]. Of recordings at one rate R0
/// holds the charge transfer, and its energy is of both.
static std::vector<std::pair<double, double>> laws_off(const IdentifyResult& result, const LawsCell& cell) {
  const ResistanceLaws& laws = result.model.laws;
  const Eigen::VectorXd sigma = result.uncertainty.sigma.tail(ResistanceLaws::kCount);
  std::vector<std::pair<double, double>> out{
          {laws.branch_kj_per_mol[0].resistance - cell.r1_kj, sigma(ResistanceLaws::resistance(0))},
          {laws.branch_kj_per_mol[1].resistance - cell.r2_kj, sigma(ResistanceLaws::resistance(1))},
          {laws.branch_kj_per_mol[0].time_constant - cell.tau1_kj, sigma(ResistanceLaws::time_constant(0))},
          {laws.branch_kj_per_mol[1].time_constant - cell.tau2_kj, sigma(ResistanceLaws::time_constant(1))},
          {laws.entropy_mv_per_k - cell.entropy_mv_per_k, sigma(ResistanceLaws::kEntropy)}};
  if (laws.has_charge_transfer())
    out.emplace_back(laws.ohmic_kj_per_mol - cell.ohmic_kj, sigma(ResistanceLaws::kOhmic));
  return out;
}

TEST(DrawnLaws, AreWithinTheirIntervalsAndPredictAColderFasterTest) {
  constexpr int kDraws = 10;
  int inside = 0, all = 0;
  for (int k = 0; k < kDraws; ++k) {
    const LawsCell cell = LawsCell::draw(draw);
    const auto plan = cell.pulses({1.0, 3.0});
    const CellIdentification found =
        identified({cell.record(plan, 25.0), cell.record(plan, 8.0), cell.record(plan, 42.0)});
    const IdentifyResult& result = found.points[0].result;
    for (const auto& [off, one_sigma] : laws_off(result, cell)) {
      ++all;
      inside += std::abs(off) <= 1.96 * one_sigma ? 1 : 0;
      CHECK_TRUE_TEXT(std::abs(off) <= 5.0 * one_sigma, about(k, "a law five sigma off").asCharString());
    }
    const Prediction unseen = predict(result.model, cell, cell.record(cell.pulses({2.0, 4.0}), -2.0));
    CHECK_TRUE_TEXT(unseen.rms_v < 0.02 * unseen.overvoltage_v + 2.0 * cell.noise_v,
                    about(k, StringFromFormat("unseen cold test missed by %.2f mV of %.1f", 1e3 * unseen.rms_v,
                                              1e3 * unseen.overvoltage_v).asCharString()).asCharString());
  }
  const SimpleString found = StringFromFormat("%d of %d laws inside", inside, all);
  CHECK_TRUE_TEXT(inside >= 0.85 * all, about(kDraws, found.asCharString()).asCharString());
}

TEST(DrawnLaws, TwoRecordingsTogetherPredictAThirdAsWellAsTheBetterOne) {
  constexpr int kDraws = 7;
  constexpr double kWorst = 2.0, kNoise_v = 1e-3;
  std::vector<double> ratios;
  int worse = 0;
  SimpleString found;
  for (int k = 0; k < kDraws; ++k) {
    const LawsCell cell = LawsCell::draw(draw);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
    const CellLog a = cell.record(cell.pulses({uniform(0.8, 1.5)}), uniform(15.0, 40.0)),
                  b = cell.record(cell.pulses({uniform(2.0, 4.0)}), uniform(0.0, 30.0)),
                  c = cell.record(cell.pulses({uniform(0.8, 4.0)}), uniform(0.0, 40.0));
    const auto error = [&](const std::vector<CellLog>& logs) {
      return predict(identified(logs).points[0].result.model, cell, c).rms_v;
    };
    const double alone = std::min(error({a}), error({b})), together = error({a, b});
    ratios.push_back(together / alone);
    if (together <= kWorst * alone + kNoise_v) continue;
    ++worse;
    found += about(k, StringFromFormat("%.2f mV together, %.2f alone\n", 1e3 * together, 1e3 * alone).asCharString());
  }
  // One rate at each of two temperatures: what the current does and what the temperature does are told apart by what
  // is believed of cells, which may be wrong for one of them. Of 730 drawn here, five were; two of seven are no chance.
  CHECK_TRUE_TEXT(worse <= 1, found.asCharString());
  std::sort(ratios.begin(), ratios.end());
  CHECK_TRUE_TEXT(ratios[kDraws / 2] <= 1.05, about(kDraws, "together worse in the middle draw").asCharString());
}

TEST(DrawnLaws, RatesAndTemperaturesThatHardlyDifferAreSureOfNoEnergy) {
  // What a little more current does is no energy of a few kelvin. Three deviations are passed by one draw of 370 where
  // all is right, and of 330 drawn here one ended in a wrong minimum (1.09C and 1.40C, 0.4 K apart); two of eight are
  // no chance.
  constexpr int kDraws = 8;
  int outside = 0;
  SimpleString told;
  for (int k = 0; k < kDraws; ++k) {
    const LawsCell cell = LawsCell::draw(draw);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
    const double rate = uniform(1.0, 2.5), more = rate * uniform(1.1, 1.45), at_c = uniform(5.0, 35.0);
    const double warmer_c = at_c + uniform(-3.0, 3.0);
    const IdentifyResult result =
        identified({cell.record(cell.pulses({rate}), at_c), cell.record(cell.pulses({more}), warmer_c)})
            .points[0]
            .result;
    const double off = result.model.laws.ohmic_kj_per_mol - cell.ohmic_kj;
    const double sigma = result.uncertainty.sigma.tail(ResistanceLaws::kCount)(ResistanceLaws::kOhmic);
    const SimpleString found = StringFromFormat("%.2fC at %.1f and %.2fC at %.1f degC: E0 off by %.1f +- %.1f kJ/mol",
                                                rate, at_c, more, warmer_c, off, sigma);
    if (std::abs(off) <= 3.0 * sigma) continue;
    ++outside;
    told += about(k, found.asCharString());
  }
  CHECK_TRUE_TEXT(outside <= 1, told.asCharString());
}

TEST(DrawnLaws, OfAnyRatesAndTemperaturesAreWithinTheirIntervals) {
  constexpr int kDraws = 10;
  int inside = 0, all = 0, far = 0;
  SimpleString told;
  for (int k = 0; k < kDraws; ++k) {
    const LawsCell cell = LawsCell::draw(draw);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
    const auto recordings = std::uniform_int_distribution<std::size_t>(2, 4)(draw);
    std::vector<CellLog> logs;
    SimpleString plan;
    while (logs.size() < recordings) {
      std::vector<double> rates(std::uniform_int_distribution<std::size_t>(1, 3)(draw));
      for (double& rate : rates) rate = std::exp(uniform(std::log(0.3), std::log(4.0)));
      logs.push_back(cell.record(cell.pulses(rates), uniform(-5.0, 45.0)));
      plan += StringFromFormat(" %.1f degC", logs.back().temperature_c.front());
      for (const double rate : rates) plan += StringFromFormat(" %.2fC", rate);
    }
    const IdentifyResult result = identified(logs).points[0].result;
    int number = 0;
    bool is_far = false;
    for (const auto& [off, sigma] : laws_off(result, cell)) {
      ++all;
      inside += std::abs(off) <= 1.96 * sigma ? 1 : 0;
      ++number;
      if (std::abs(off) <= 5.0 * sigma) continue;
      is_far = true;
      told += about(k, StringFromFormat("law %d off %.3g +- %.3g:%s\n", number, off, sigma, plan.asCharString())
                           .asCharString());
    }
    far += is_far ? 1 : 0;
  }
  // Of 120 cells drawn like these one had such laws, of 120 others another: a slow branch in the cold outlasts rests of
  // ten minutes, and a fit of so many laws may end beside the best one.
  CHECK_TRUE_TEXT(far <= 1, told.asCharString());
  const SimpleString found = StringFromFormat("%d of %d laws inside", inside, all);
  CHECK_TRUE_TEXT(inside >= 0.85 * all, about(kDraws, found.asCharString()).asCharString());
}

TEST(DrawnLaws, RestsInTheColdTellTheEntropyAlsoWhereTheCircuitIsNotAllThereIs) {
  // Then rests hold the open-circuit voltage; each at its own temperature. Of 125 drawn cells 4 were further off than
  // that, by 0.16 mV/K at most: not mended yet.
  constexpr int kDraws = 5;
  constexpr double kFarthest = 0.2;
  int far = 0;
  SimpleString told;
  for (int k = 0; k < kDraws; ++k) {
    LawsCell cell = LawsCell::draw(draw);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
    cell.entropy_mv_per_k = (k % 2 == 0 ? 1.0 : -1.0) * uniform(0.15, 0.4);
    const double cold_c = uniform(-12.0, 0.0), ripple_v = uniform(0.7e-3, 1.5e-3);
    std::vector<CellLog> logs{cell.record(cell.pulses({1.5}), 25.0), cell.record(cell.pulses({0.8}), cold_c)};
    for (CellLog& log : logs) add_ripple(log, cell, ripple_v);
    const IdentifyResult result = identified(logs).points[0].result;
    const SimpleString found = StringFromFormat("%.1f degC, ripple %.2f mV: entropy %.4f, true %.4f mV/K", cold_c,
                                                1e3 * ripple_v, result.model.laws.entropy_mv_per_k,
                                                cell.entropy_mv_per_k);
    // The ripple stands in every rest of a test, of thirty kelvin it is a thirtieth.
    const double most = 0.01 + 1e3 * ripple_v / (25.0 - cold_c) / 2.0;
    const double off = std::abs(result.model.laws.entropy_mv_per_k - cell.entropy_mv_per_k);
    CHECK_TRUE_TEXT(off <= kFarthest, about(k, found.asCharString()).asCharString());
    if (off <= most) continue;
    ++far;
    told += about(k, found.asCharString()) + "\n";
  }
  CHECK_TRUE_TEXT(far <= 1, told.asCharString());
}

TEST(DrawnLaws, OfAColdSlowRecordingBesideAWarmOneHaveTheirChargeTransfer) {
  // From what is believed of the exchange current the fit ended far off; without one R0's energy was sure and wrong.
  LawsCell cell;
  cell.capacity_ah = 10.0;
  cell.r0_ohm = 4e-3;
  cell.r1_ohm = cell.r2_ohm = 3e-3;
  cell.exchange_a = 30.0;
  const IdentifyResult result =
      identified({cell.record(cell.pulses({0.81}), 40.7), cell.record(cell.pulses({0.49, 0.34, 0.99}), -2.0)})
          .points[0]
          .result;
  CHECK(result.model.laws.has_charge_transfer());
  for (const auto& [off, sigma] : laws_off(result, cell)) CHECK(std::abs(off) <= 4.0 * sigma);
}

TEST(DrawnLaws, OfBranchesThatComeNearEachOtherInTheColdAreEachItsOwn) {
  // As it was drawn: from energies that are alike the fast branch got the slow one's, and all five were far off.
  LawsCell cell;
  cell.capacity_ah = 30.164;
  cell.r0_ohm = 1.447e-3, cell.r1_ohm = 0.707e-3, cell.r2_ohm = 1.527e-3;
  cell.tau1_s = 18.9, cell.tau2_s = 155.0;
  cell.ohmic_kj = 26.1, cell.r1_kj = 28.6, cell.r2_kj = 16.9, cell.tau1_kj = 35.4, cell.tau2_kj = 2.7;
  cell.exchange_a = 64.4;
  const IdentifyResult result =
      identified({cell.record(cell.pulses({0.52, 0.46, 0.34}), -3.0), cell.record(cell.pulses({0.77}), 36.2),
                  cell.record(cell.pulses({2.15, 1.02}), 20.5), cell.record(cell.pulses({0.54}), 18.9)})
          .points[0]
          .result;
  for (const auto& [off, sigma] : laws_off(result, cell))
    CHECK_TRUE_TEXT(std::abs(off) <= 4.0 * sigma, StringFromFormat("%.3g +- %.3g", off, sigma).asCharString());
}

TEST(DrawnLaws, OfOneTemperatureAreAssumedAndSaySo) {
  const LawsCell cell;
  const CellIdentification found = identified({cell.record(cell.pulses({1.0}), 25.0)});
  const IdentifyResult& result = found.points[0].result;
  DOUBLES_EQUAL(15.0, result.model.laws.ohmic_kj_per_mol, 0.1);
  DOUBLES_EQUAL(10.0, result.uncertainty.sigma.tail(ResistanceLaws::kCount)(ResistanceLaws::kOhmic), 2.0);
  CHECK(!result.model.laws.has_charge_transfer());
}

TEST(DrawnLaws, AtOneTemperatureWhatACellWarmsIsNoBendOverTheCurrent) {
  // A cell without a charge transfer that is warmer at the higher rate, as it warms itself there, has less resistance.
  constexpr int kDraws = 2;
  for (int k = 0; k < kDraws; ++k) {
    LawsCell cell = LawsCell::draw(draw);
    const auto uniform = [&](double low, double high) { return std::uniform_real_distribution(low, high)(draw); };
    cell.exchange_a = 0.0;
    cell.ohmic_kj = uniform(25.0, 40.0);
    cell.r1_kj = cell.r2_kj = uniform(35.0, 45.0);
    const double at_c = uniform(20.0, 28.0), warmer_c = at_c + uniform(3.0, 6.0);
    std::vector<CellLog> logs{cell.record(cell.pulses({1.0}), at_c), cell.record(cell.pulses({3.0}), warmer_c)};
    for (CellLog& log : logs) add_ripple(log, cell, 1e-3);
    const IdentifyResult result = identified(logs).points[0].result;
    const ResistanceLaws& laws = result.model.laws;
    const SimpleString of = StringFromFormat("1C at %.1f, 3C at %.1f degC, %.1f and %.1f kJ/mol, found %.1f and %.1f",
                                             at_c, warmer_c, cell.ohmic_kj, cell.r1_kj, laws.ohmic_kj_per_mol,
                                             laws.branch_kj_per_mol[0].resistance);
    CHECK_TRUE_TEXT(!laws.has_charge_transfer(), about(k, of.asCharString()).asCharString());
    // What it warms tells its energy where that takes more than an error of the circuit would.
    CHECK_TRUE_TEXT(result.laws_assumed || std::abs(laws.ohmic_kj_per_mol - cell.ohmic_kj) < 8.0,
                    about(k, of.asCharString()).asCharString());
  }
}
