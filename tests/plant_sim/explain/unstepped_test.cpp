// SPDX-License-Identifier: Apache-2.0
#include "explain/model/unstepped.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include "explain/model/readings.hpp"

namespace voltlap::explain {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// One thermistor that is read every 0.2 s, with noise and steps.
plant::Recording read_by(const VectorXd& truth, double noise_k, double step_k, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  plant::Recording log;
  log.time_s = VectorXd::LinSpaced(truth.size(), 0.0, 0.2 * static_cast<double>(truth.size() - 1));
  VectorXd& read = log.signals["temperature_1"];
  read = truth;
  for (double& value : read) value = step_k * std::round((value + noise_k * normal(random)) / step_k);
  return log;
}

/// A step cannot always be taken away: noise may be all on one side, a lap may turn at a middle. One in twenty may
/// miss.
struct Misses {
  unsigned of = 600, missed = 0;
  std::string seeds;
  void count(bool kept, unsigned seed) {
    if (kept) return;
    ++missed;
    seeds += " " + std::to_string(seed);
  }
  void judge() const { CHECK_TEXT(20 * missed <= of, ("seeds" + seeds).c_str()); }
};

}  // namespace

TEST_GROUP(Unstepped){};

TEST(Unstepped, AReadingThatNeverChangesMayHideAKelvinAndOneThatChangesOnceItsStep) {
  const double kHidden = 1.0 / std::sqrt(12.0);  // of a step
  plant::Recording log;
  DOUBLES_EQUAL(0.0, step_error_of_heat(log), 0.0);
  VectorXd& first = log.signals["temperature_1"] = VectorXd::Constant(100, 25.0);
  DOUBLES_EQUAL(kHidden, step_error_of_heat(log), 1e-12);
  first.tail(40).setConstant(27.0);
  DOUBLES_EQUAL(2.0 * kHidden, step_error_of_heat(log), 1e-12);
  log.signals["temperature_2"] = VectorXd::Constant(100, 25.0);
  DOUBLES_EQUAL(2.0 * kHidden, step_error_of_heat(log), 1e-12);
  log.signals["temperature_2"].tail(20).setConstant(25.5);
  DOUBLES_EQUAL(0.5 * kHidden, step_error_of_heat(log), 1e-12);
}

TEST(Unstepped, StepsOfAThermistorAreTakenAwayToATenthOfThem) {
  Misses misses;
  for (unsigned seed = 1; seed <= misses.of; ++seed) {
    std::mt19937 random(seed);
    const double rate = std::uniform_real_distribution<double>(0.003, 0.03)(random);  // K/s
    const double noise = std::uniform_real_distribution<double>(0.0, 0.25)(random);
    const double begin = std::uniform_real_distribution<double>(-10.0, 40.0)(random);
    const VectorXd truth = (begin + rate * VectorXd::LinSpaced(4000, 0.0, 799.8).array()).matrix();
    const VectorXd read = unstepped(read_by(truth, noise, 1.0, seed)).signals.at("temperature_1");
    double square = 0.0, count = 0.0;
    for (Index k = 0; k < read.size(); ++k) {
      if (!std::isfinite(read(k))) continue;
      square += (read(k) - truth(k)) * (read(k) - truth(k));
      count += 1.0;
    }
    // What lies between the first and the last step.
    misses.count(count * rate * 0.2 > 0.4 * (rate * 800.0 - 2.0) && std::sqrt(square / count) < 0.1, seed);
  }
  misses.judge();
}

TEST(Unstepped, AMiddleThatTheLogEndsOrBeginsAmidHasNoTime) {
  // 31.5 degC are passed at 300 s and 32.5 at 500 s, slowly and with noise; the log ends or begins within 5 s of one.
  for (unsigned seed = 1; seed <= 20; ++seed) {
    std::mt19937 random(seed);
    for (const bool ends : {true, false}) {
      const double offset_s = std::uniform_real_distribution<double>(-5.0, 5.0)(random);
      const double begin_s = ends ? 0.0 : 300.0 + offset_s, end_s = ends ? 500.0 + offset_s : 800.0;
      VectorXd truth(static_cast<Index>((end_s - begin_s) / 0.2));
      for (Index k = 0; k < truth.size(); ++k) truth(k) = 30.0 + (begin_s + 0.2 * static_cast<double>(k)) / 200.0;
      const plant::Recording log = read_by(truth, 0.1, 1.0, seed);
      // 31.5 alone, or 32.5 and 33.5: what is amid its passing says nothing, or stays as it is read.
      const plant::Recording whole = unstepped(log);
      const auto passed = whole.passed_s.find("temperature_1");
      for (std::size_t k = 0; passed != whole.passed_s.end() && k < passed->second.size(); ++k) {
        const double at_s = passed->second[k] + begin_s, middle_s = 100.0 + 200.0 * std::round((at_s - 100.0) / 200.0);
        CHECK_TEXT(std::abs(at_s - middle_s) < 8.0, (std::to_string(seed) + ": " + std::to_string(at_s)).c_str());
        CHECK_TEXT(ends ? at_s < 480.0 : at_s > 320.0, (std::to_string(seed) + ": " + std::to_string(at_s)).c_str());
      }
      CHECK(unstepped(log, Passes::kAny).signals.at("temperature_1").size() == truth.size());
    }
  }
}

TEST(Unstepped, AtEveryPassItIsAtTheMiddleHoweverSlowlyItGoesThereAndHoweverOften) {
  // Cooling that ends beside a middle, a day in a hall that warms and cools: for an hour the reading goes to and fro.
  // As many readings above as below say where it is to the noise over the root of the readings in the window.
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double first = drawn(-5.0, 5.0), end = drawn(10.0, 30.0), tau_s = drawn(200.0, 1500.0);
    const double slow = drawn(0.0, 1.5), slow_s = drawn(1000.0, 4000.0);
    const double fast = drawn(0.0, 0.5), fast_s = drawn(300.0, 900.0);
    VectorXd truth(20000);
    for (Index k = 0; k < truth.size(); ++k) {
      const double t = 0.2 * static_cast<double>(k);
      truth(k) = end + first * std::exp(-t / tau_s) + slow * std::sin(6.2832 * t / slow_s) +
                 fast * std::sin(6.2832 * t / fast_s);
    }
    const plant::Recording read = unstepped(read_by(truth, drawn(0.0, 0.25), 1.0, seed));
    const auto passed = read.passed_s.find("temperature_1");
    for (std::size_t k = 0; passed != read.passed_s.end() && k < passed->second.size(); ++k) {
      const double there = truth(static_cast<Index>(5.0 * passed->second[k]));
      DOUBLES_EQUAL_TEXT(std::floor(there) + 0.5, there, 0.12,
                         ("seed " + std::to_string(seed) + ": " + std::to_string(passed->second[k])).c_str());
    }
  }
}

TEST(Unstepped, AJumpAmidTheLogPassesNothingAndWhatIsBesideItIsNotLost) {
  // A reading of 0 degC for one row, as of a frame that was lost, once in each log.
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    const double rate = std::uniform_real_distribution<double>(0.01, 0.03)(random);
    const VectorXd truth = (20.2 + rate * VectorXd::LinSpaced(4000, 0.0, 799.8).array()).matrix();
    plant::Recording log = read_by(truth, 0.1, 1.0, seed);
    log.signals["temperature_1"](std::uniform_int_distribution<Index>(100, 3900)(random)) = 0.0;
    const plant::Recording read = unstepped(log);
    const std::vector<double>& passed_s = read.passed_s.at("temperature_1");
    CHECK(static_cast<double>(passed_s.size()) >= rate * 800.0 - 3.0);
    for (const double at_s : passed_s) {
      const double there = truth(static_cast<Index>(5.0 * at_s));
      DOUBLES_EQUAL_TEXT(std::floor(there) + 0.5, there, 0.1, std::to_string(seed).c_str());
    }
  }
}

TEST(Unstepped, AReadingThatBeginsWithNoughtHasPassedNothing) {
  // 0 degC until the unit has measured, for the first three readings: no way of 26 K up to the next step.
  VectorXd truth = (26.7 + 0.01 * VectorXd::LinSpaced(2000, 0.0, 399.8).array()).matrix();
  plant::Recording log = read_by(truth, 0.0, 1.0, 1);
  log.signals["temperature_1"].head(3).setZero();
  const VectorXd read = unstepped(log).signals.at("temperature_1");
  for (Index k = 0; k < read.size(); ++k) {
    if (std::isfinite(read(k))) DOUBLES_EQUAL(truth(k), read(k), 0.1);
  }
  CHECK(std::isfinite(read(1000)));
}

TEST(Unstepped, WhereItCameBackNothingIsKnown) {
  // Up by 4 K, and down again: at the top it is anywhere within a step.
  VectorXd truth(6000);
  for (Index k = 0; k < truth.size(); ++k) {
    const double from_top = static_cast<double>(k) / 3.0 - 1000.0;
    truth(k) = 24.1 - 4.3e-6 * from_top * from_top;
  }
  const VectorXd read = unstepped(read_by(truth, 0.05, 1.0, 3)).signals.at("temperature_1");
  CHECK_FALSE(std::isfinite(read(3000)));
  CHECK(std::isfinite(read(1200)));
  DOUBLES_EQUAL(truth(1200), read(1200), 0.15);
}

TEST(Unstepped, FineStepsAndAThermistorThatStandsStayAsTheyAre) {
  const VectorXd ramp = VectorXd::LinSpaced(2000, 20.0, 26.0), flat = VectorXd::Constant(2000, 22.2);
  const plant::Recording fine = read_by(ramp, 0.02, 0.1, 1), stands = read_by(flat, 0.05, 1.0, 2);
  CHECK(fine.signals.at("temperature_1") == unstepped(fine).signals.at("temperature_1"));
  CHECK(stands.signals.at("temperature_1") == unstepped(stands).signals.at("temperature_1"));
}

TEST(Unstepped, AModelThatIsRightLeavesNothingHoweverItMovesBetweenTheSteps) {
  // Cells that warm and cool with every lap, 0.1 to 0.6 K beside the straight line that coarse steps show: 0.05 to
  // 0.3 K were held against a model that had them. What is left is the time between two readings.
  Misses misses;
  for (unsigned seed = 1; seed <= misses.of; ++seed) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    const double rate = drawn(0.004, 0.03), lap_s = drawn(40.0, 120.0), begin = drawn(-10.0, 40.0);
    const double swing = drawn(0.1, 0.6), step = drawn(0.5, 1.0);
    VectorXd truth(4000);
    for (Index k = 0; k < truth.size(); ++k) {
      const double t = 0.2 * static_cast<double>(k);
      truth(k) = begin + rate * t + swing * std::sin(6.2832 * t / lap_s);
    }
    const plant::Recording read = unstepped(read_by(truth, 0.0, step, seed));
    const Reader reader = Reader::of_roles(read, {"temperature_1"}, 2.0);
    if (reader.size() == 0) continue;
    const VectorXd left = reader.values() - reader.of(truth);
    const double fastest = rate + swing * 6.2832 / lap_s;
    misses.count(left.cwiseAbs().maxCoeff() < 0.2 * fastest, seed);
  }
  misses.judge();
}

}  // namespace voltlap::explain
