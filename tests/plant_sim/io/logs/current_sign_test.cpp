// SPDX-License-Identifier: Apache-2.0
#include "io/logs/current_sign.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <random>
#include <string>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

unsigned seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoul(given, nullptr, 10)) : 1U;
}

enum class Kind { kDrive, kDischarge, kCharge, kCycles, kPulses, kEmptied };
constexpr Kind kKinds[] = {Kind::kDrive,  Kind::kDischarge, Kind::kCharge,
                           Kind::kCycles, Kind::kPulses,    Kind::kEmptied};

/// A cell of 5 Ah with one slow branch under a drawn current; its voltage comes late, its rows at any interval.
struct Drawn {
  explicit Drawn(std::mt19937& random) : random_(random) {
    const auto between = [&](double low, double high) { return std::uniform_real_distribution(low, high)(random_); };
    kind = kKinds[random_() % std::size(kKinds)];
    every_s = std::exp(between(std::log(0.1), std::log(20.0)));
    late_s = between(0.0, 2.0);
    sign = random_() % 2 == 0 ? 1.0 : -1.0;
    ohm = between(0.005, 0.03);
    soc = kind == Kind::kCharge ? between(0.0, 0.3) : between(0.7, 1.0);
    amps = between(2.0, 25.0);
    rows = static_cast<int>(between(300.0, 1500.0));
    noise_v = between(0.0, 0.005);
    rise_v = random_() % 2 == 0 ? 0.85 : 0.05;  // over the charge: of a nickel or of an iron phosphate cathode
  }

  [[nodiscard]] CellLog log() {
    CellLog out;
    std::normal_distribution<double> noise(0.0, 1.0);
    constexpr double kStep_s = 0.1;
    std::vector<double> volts, current;
    double branch_v = 0.0, asked = 0.0;
    const auto steps = static_cast<std::size_t>(rows * every_s / kStep_s);
    for (std::size_t k = 0; k < steps && soc > -0.01 && soc < 1.01; ++k) {
      const double t = kStep_s * static_cast<double>(k);
      asked = current_at(t, asked);
      soc -= asked * kStep_s / 3600.0 / 5.0;
      branch_v += kStep_s / 30.0 * (0.7 * ohm * asked - branch_v);
      const double low = 0.9 * std::exp(-std::max(soc, 0.0) / 0.02);
      volts.push_back(3.3 + rise_v * soc - low - ohm * asked - branch_v);
      current.push_back(asked);
    }
    for (int row = 0; row < rows; ++row) {
      const auto at = static_cast<std::size_t>(row * every_s / kStep_s);
      if (at >= volts.size()) break;
      const auto before = static_cast<std::size_t>(late_s / kStep_s);
      out.time_s.push_back(row * every_s);
      out.current_a.push_back(sign * current[at]);
      out.voltage_v.push_back(volts[at > before ? at - before : 0] + noise_v * noise(random_));
      out.gap.push_back(false);
    }
    return out;
  }

  [[nodiscard]] std::string text() const {
    return "kind " + std::to_string(static_cast<int>(kind)) + ", every " + std::to_string(every_s) + " s, late " +
           std::to_string(late_s) + " s, rise " + std::to_string(rise_v) + " V, sign " + std::to_string(sign) +
           ", rows " + std::to_string(rows);
  }

  Kind kind;
  double every_s, late_s, sign, ohm, soc, amps, noise_v, rise_v;
  int rows;

 private:
  double current_at(double t, double before) {
    const double phase = std::fmod(t, 600.0);
    switch (kind) {
      case Kind::kDischarge:
        return t < 30.0 ? 0.0 : amps;
      case Kind::kCharge:
        return t < 30.0 ? 0.0 : -amps * std::clamp((1.0 - soc) / 0.1, 0.05, 1.0);
      case Kind::kCycles:
        return phase < 200.0 ? amps : (phase < 300.0 ? 0.0 : (phase < 500.0 ? -0.8 * amps : 0.0));
      case Kind::kEmptied:  // and left there, at the lowest voltage of all
        return t < 30.0 || soc < 0.0 ? 0.0 : amps;
      case Kind::kPulses:
        return phase < 30.0 ? amps : (phase > 100.0 && phase < 110.0 ? -0.7 * amps : 0.0);
      default:
        if (random_() % 12 != 0) return before;
        return amps * std::uniform_real_distribution(-0.4, 1.0)(random_);
    }
  }

  std::mt19937& random_;
};

}  // namespace

TEST_GROUP(CurrentSign) {};

TEST(CurrentSign, AnyRecordingOfACellTellsItAlsoWhereTheVoltageComesLate) {
  std::mt19937 random(seed());
  int judged = 0, open = 0;
  for (int trial = 0; trial < 300; ++trial) {
    Drawn drawn(random);
    const CellLog log = drawn.log();
    if (log.rows() < 100) continue;
    ++judged;
    const double evidence = whole_sign_evidence(log);
    const std::string said = "VOLTLAP_TEST_SEED=" + std::to_string(seed()) + ", trial " + std::to_string(trial) + ": " +
                             drawn.text() + ", evidence " + std::to_string(evidence);
    open += std::abs(evidence) < 0.2 ? 1 : 0;
    CHECK_TEXT(evidence * drawn.sign < 0.0 || std::abs(evidence) < 0.2, said.c_str());
  }
  CHECK(judged > 200);
  const auto count = StringFromFormat("VOLTLAP_TEST_SEED=%u: %d of %d open", seed(), open, judged);
  CHECK_TEXT(open * 20 <= judged, count.asCharString());
}

TEST(CurrentSign, MinutesOfADriveTellItThoughTheVoltageIsASecondLate) {
  // Little charge, so that the current must say it: step by step a late voltage answers to the step before.
  std::mt19937 random(seed());
  for (int trial = 0; trial < 40; ++trial) {
    Drawn drawn(random);
    drawn.kind = Kind::kDrive;
    drawn.every_s = 0.1;
    drawn.rows = 1500;
    drawn.late_s = std::uniform_real_distribution(0.8, 1.5)(random);
    drawn.amps = 10.0;
    drawn.ohm = 0.03;
    const double evidence = whole_sign_evidence(drawn.log());
    const auto said = StringFromFormat("VOLTLAP_TEST_SEED=%u, trial %d: %s, evidence %.3f", seed(), trial,
                                       drawn.text().c_str(), evidence);
    CHECK_TEXT(evidence * drawn.sign < -0.2, said.asCharString());
  }
}

TEST(CurrentSign, ChannelsWithRatesOfTheirOwnTellTheSame) {
  std::mt19937 random(seed());
  for (int trial = 0; trial < 60; ++trial) {
    Drawn drawn(random);
    const CellLog log = drawn.log();
    if (log.rows() < 100) continue;
    Channel current, voltage;
    for (std::size_t row = 0; row < log.rows(); ++row) {
      current.time_s.push_back(log.time_s[row]);
      current.value.push_back(row % 17 == 16 ? std::nan("") : log.current_a[row]);
      if (row % 2 != 0) continue;
      voltage.time_s.push_back(log.time_s[row]);
      voltage.value.push_back(log.voltage_v[row]);
    }
    const double evidence = whole_sign_evidence(current, voltage);
    const auto said = StringFromFormat("VOLTLAP_TEST_SEED=%u, trial %d: %s, evidence %.3f", seed(), trial,
                                       drawn.text().c_str(), evidence);
    CHECK_TEXT(evidence * drawn.sign < 0.0 || std::abs(evidence) < 0.2, said.asCharString());
    const double of_rows = whole_sign_evidence(log);
    CHECK_TEXT(std::abs(of_rows) < 0.6 || std::abs(evidence) > 0.2, said.asCharString());
  }
}

TEST(CurrentSign, APartAfterAGapHasItsOwnCharge) {
  CellLog log;
  for (int k = 0; k < 400; ++k) {
    const bool second = k >= 200;  // charged in between: the voltage stands higher than before
    log.time_s.push_back(k + (second ? 5000.0 : 0.0));
    log.current_a.push_back(5.0);
    log.voltage_v.push_back((second ? 4.1 : 3.5) - 0.0005 * (k % 200));
    log.gap.push_back(k == 200);
  }
  DOUBLES_EQUAL(-1.0, whole_sign_evidence(log), 1e-9);
}

TEST(CurrentSign, AVoltageThatDoesNotAnswerSaysNothing) {
  CellLog log;
  for (int k = 0; k < 200; ++k) {
    log.time_s.push_back(k);
    log.current_a.push_back(k % 7 == 0 ? 10.0 : 0.0);
    log.voltage_v.push_back(3.7);
    log.gap.push_back(false);
  }
  DOUBLES_EQUAL(0.0, whole_sign_evidence(log), 0.0);
}
