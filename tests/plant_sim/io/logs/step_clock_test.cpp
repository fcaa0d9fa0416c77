// SPDX-License-Identifier: Apache-2.0
// Dates in whole seconds beside a clock of the step that is finer.
#include "io/logs/step_clock.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstdlib>
#include <random>
#include <string>
#include <vector>

#include "io/logs/cell_log.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

unsigned drawn_seed() {
  const char* given = std::getenv("VOLTLAP_TEST_SEED");
  return given != nullptr ? static_cast<unsigned>(std::strtoull(given, nullptr, 10)) : std::random_device{}();
}

/// A test of drawn steps that begins at a drawn fraction of a second, as Neware exports it.
struct Test {
  std::string text =
      "Record number,Steps,Current(mA),Voltage(V),Relative Time(h:min:s.ms),Date(h:min:s.ms)\n";
  std::vector<double> time_s;

  Test(unsigned seed, double row_s) {
    std::mt19937 random(seed);
    const auto drawn = [&](double low, double high) {
      return std::uniform_real_distribution<double>(low, high)(random);
    };
    double begin_s = 3600.0 * 8 + drawn(0.0, 1.0);
    for (int step = 0; step < 12; ++step) {
      const int rows = static_cast<int>(drawn(5.0, 400.0));
      const double milliamperes = step % 2 == 0 ? 0.0 : -1000.0;
      const bool repeats = step > 0 && drawn(0.0, 1.0) < 0.5;  // the row in which the step before ended
      for (int row = step == 0 || repeats ? 0 : 1; row <= rows; ++row) {
        const double clock_s = row_s * row, now_s = begin_s + clock_s;
        if (row > 0 || step == 0) time_s.push_back(now_s);
        text += fmt::format("{},{},{},{:.4f},{:02}:{:02}:{:06.3f},2026-03-14 {:02}:{:02}:{:02}\n", time_s.size(), step,
                            milliamperes, 3.7 + 1e-4 * milliamperes, static_cast<int>(clock_s) / 3600,
                            static_cast<int>(clock_s) / 60 % 60, std::fmod(clock_s, 60.0),
                            static_cast<int>(now_s) / 3600, static_cast<int>(now_s) / 60 % 60,
                            static_cast<int>(now_s) % 60);
      }
      begin_s += row_s * rows;
    }
  }
};

}  // namespace

TEST_GROUP(StepClock){};

TEST(StepClock, TellsWhatDatesInSecondsLeaveOut) {
  const unsigned first = drawn_seed();
  for (unsigned seed = first; seed < first + 20; ++seed) {
    std::mt19937 random(seed);
    const double row_s = 0.05 * std::uniform_int_distribution<int>(1, 18)(random);
    const Test test(seed, row_s);
    const Scratch scratch;
    const std::string path = scratch.write("test.csv", test.text);
    const CellLog log = read_cell_log(path, nullptr, DataFolder(VOLTLAP_DATA_FOLDER));
    const std::string words = fmt::format("VOLTLAP_TEST_SEED={}", seed);
    LONGS_EQUAL_TEXT(test.time_s.size(), log.rows(), words.c_str());
    for (std::size_t row = 0; row < log.rows(); ++row) {
      const double apart = (log.time_s[row] - log.time_s[0]) - (test.time_s[row] - test.time_s[0]);
      CHECK_TEXT(std::abs(apart) < 1e-3, fmt::format("{}, row {}: {:.4f} s", words, row, apart).c_str());
    }
  }
}

TEST(StepClock, DatesThatAreFineEnoughStayAsTheyAre) {
  const unsigned seed = drawn_seed();
  const Test test(seed, 1.0);
  const Scratch scratch;
  const CellLog log =
      read_cell_log(scratch.write("test.csv", test.text), nullptr, DataFolder(VOLTLAP_DATA_FOLDER));
  for (const std::string& note : log.repairs) CHECK_TEXT(note.find("too coarse") == std::string::npos, note.c_str());
}
