// SPDX-License-Identifier: Apache-2.0
#include "explain/model/readings.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <string>

namespace voltlap::explain {
namespace {

/// Rows of 10 ms; each of the cells is read every 30 ms, 7 ms after another, and held between.
plant::Recording slow_cells(Index rows, int cells) {
  plant::Recording log;
  log.time_s = VectorXd::LinSpaced(rows, 0.0, 0.01 * static_cast<double>(rows - 1));
  log.signals["current"] = VectorXd::Zero(rows);
  for (int cell = 1; cell <= cells; ++cell) {
    VectorXd values(rows), read(rows);
    for (Index row = 0; row < rows; ++row) {
      const double first = 0.007 * cell;
      const double turns = std::max(0.0, std::floor((log.time_s(row) - first) / 0.03 + 1e-9));
      read(row) = first + 0.03 * turns;
      values(row) = read(row) <= log.time_s(row) ? 3.0 + read(row) : std::nan("");
    }
    const std::string role = "cell_voltage_" + std::to_string(cell);
    log.signals[role] = values;
    log.read_s[role] = read;
  }
  return log;
}

}  // namespace

TEST_GROUP(Readings){};

TEST(Readings, AReadingIsHeldAgainstTheModelAtItsOwnTime) {
  const plant::Recording log = slow_cells(2000, 3);
  const Reader reader = Reader::of_roles(log, log.numbered("cell_voltage_"), 0.1);
  // The model is right: 3 V and a volt a second. What is held would be 15 ms late in the mean.
  const VectorXd left = reader.values() - reader.of((log.time_s.array() + 3.0).matrix());
  CHECK(reader.size() > 150);
  DOUBLES_EQUAL(0.0, left.cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Readings, ABinCountsOnlyWithAllSensorsAndEachTheSame) {
  plant::Recording log = slow_cells(2000, 2);
  VectorXd& second = log.signals.at("cell_voltage_2");
  second.segment(500, 500).setConstant(std::nan(""));
  const Reader reader = Reader::of_roles(log, log.numbered("cell_voltage_"), 0.1);
  for (const double t : reader.time_s()) CHECK_TEXT(t < 5.1 || t > 9.9, "one of two cells is missing there");
  const Reader first = Reader::of_roles(log, {"cell_voltage_1"}, 0.1);
  CHECK(first.size() > reader.size() + 40);
}

TEST(Readings, BinsOfAnotherReaderAreMatchedByTime) {
  const plant::Recording log = slow_cells(2000, 2);
  const Reader both = Reader::of_roles(log, log.numbered("cell_voltage_"), 0.1);
  const Reader one = Reader::of_roles(log, {"cell_voltage_1"}, 0.1);
  const VectorXd matched = one.matched(both, both.time_s());
  for (Index k = 0; k < matched.size(); ++k) {
    if (std::isfinite(matched(k))) DOUBLES_EQUAL(one.time_s()(k), matched(k), 0.05);
  }
}

TEST(Readings, BinsThatAreLeftOutTakeTheirReadingsWithThem) {
  const plant::Recording log = slow_cells(2000, 2);
  Reader reader = Reader::of_roles(log, log.numbered("cell_voltage_"), 0.1);
  const Reader before = reader;
  std::vector<bool> kept;
  for (Index k = 0; k < before.size(); ++k) kept.push_back(k % 3 != 0);
  reader.keep(kept);
  const VectorXd times = reader.of(log.time_s);
  Index at = 0;
  for (Index k = 0; k < before.size(); ++k) {
    if (k % 3 == 0) continue;
    DOUBLES_EQUAL(before.values()(k), reader.values()(at), 0.0);
    DOUBLES_EQUAL(before.time_s()(k), times(at), 1e-12);
    ++at;
  }
  LONGS_EQUAL(at, reader.size());
}

TEST(Readings, WhatIsReadBetweenTheSameRowsIsMergedAndTheMeanStaysThatOfEachReading) {
  const plant::Recording log = slow_cells(2000, 7);
  const VectorXd by_row = (3.0 * log.time_s.array()).sin() + log.time_s.array().square() * 0.01;
  const auto roles = log.numbered("cell_voltage_");
  const Reader all = Reader::of_roles(log, roles, 0.1);
  VectorXd mean = VectorXd::Zero(all.size());
  for (const std::string& role : roles) {
    const Reader one = Reader::of_roles(log, {role}, 0.1);
    mean += all.matched(one, one.of(by_row)) / static_cast<double>(roles.size());
  }
  CHECK(all.size() > 150);
  DOUBLES_EQUAL(0.0, (all.of(by_row) - mean).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(Readings, ARowWithoutAValueHasThatOfTheRowBeforeAndTheFirstOnesThatOfTheFirstThatHasOne) {
  const double nothing = std::nan("");
  VectorXd rows(6), expected(6);
  rows << nothing, nothing, 2.0, nothing, 5.0, nothing;
  expected << 2.0, 2.0, 2.0, 2.0, 5.0, 5.0;
  CHECK(filled(rows) == expected);
  CHECK(filled(VectorXd::Constant(3, nothing)) == VectorXd::Zero(3));
}

TEST(Readings, AClockThatJumpsAheadTakesNoMemory) {
  plant::Recording log = slow_cells(2000, 1);
  log.time_s.tail(1000).array() += 1.7e9;  // 1970, then now
  log.read_s.at("cell_voltage_1").tail(1000).array() += 1.7e9;
  const Reader reader = Reader::of_roles(log, {"cell_voltage_1"}, 0.1);
  CHECK(reader.size() > 190 && reader.size() < 210);
}

}  // namespace voltlap::explain
