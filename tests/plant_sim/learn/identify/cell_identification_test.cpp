// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/cell_identification.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "car/battery/cell_tables.hpp"
#include "known_cell.hpp"
#include "learn/identify/common_time_constants.hpp"
#include "learn/identify/result/cell_file.hpp"
#include "learn/identify/result/cell_parameters.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CellIdentification) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  KnownCell cell;
  IdentifyOptions options;
  std::vector<std::string> notes;
  void setup() override {
    options.branches = 2;
  }
  CellBody body_of(const CellIdentification& identified) {
    return cell_body({}, identified.reference_point().result.capacity,
                     [&](const std::string& name) { return load_cell(data, name, "test"); });
  }
  CellParameters written_and_read(const CellIdentification& identified) {
    const CellParameters made = cell_parameters(identified, body_of(identified), "known", notes);
    return load_cell(data, scratch.write("known.toml", cell_toml(made, body_of(identified), identified)), "test");
  }
};

TEST(CellIdentification, CellFileIsReadBackAsItWasMade) {
  const CellIdentification identified = identify_cell({cell.record(cell.pulse_plan(33.0, 500, 0.0))}, {30.0}, options);
  const CellParameters read = written_and_read(identified);
  STRCMP_EQUAL("known", read.name.c_str());
  const CellTables tables(read);
  const CircuitModel& model = identified.points[0].result.model;
  DOUBLES_EQUAL(1.0, tables.circuit(0.5, 30.0, 33.0).r0_ohm / model.r(8, 0), 1e-4);
  DOUBLES_EQUAL(1.0, tables.circuit(0.5, 30.0, 33.0).tau_s[1] / model.tau(8, 1), 1e-4);
  DOUBLES_EQUAL(model.ocv.value(model.em, 0.5), tables.ocv(0.5).voltage_v, 1e-5);
  // One temperature tested: the assumed activation energy of 15 kJ/mol leads away from it.
  const double arrhenius = std::exp(15e3 / kGasConstant * (1.0 / 313.15 - 1.0 / 303.15));
  DOUBLES_EQUAL(arrhenius, tables.circuit(0.5, 40.0, 33.0).r0_ohm / tables.circuit(0.5, 30.0, 33.0).r0_ohm, 1e-3);
}

TEST(CellIdentification, ACellFileHoldsTheBranchesThatWereFittedAndNoOther) {
  for (int branches = 1; branches <= 4; ++branches) {
    options.branches = branches;
    const CellLog log = cell.record(cell.pulse_plan(33.0, 300, 0.0));
    const CellIdentification identified = identify_cell({log}, {30.0}, options);
    const CellParameters made = cell_parameters(identified, body_of(identified), "known", notes);
    const std::string file = cell_toml(made, body_of(identified), identified),
                      json = identification_json(made, body_of(identified), identified, "1.0");
    const CellParameters read = written_and_read(identified);
    LONGS_EQUAL(branches, read.branch_count());
    const CircuitModel& model = identified.points[0].result.model;
    const CircuitParameters p = CellTables(read).circuit(0.5, 30.0, read.reference_current_a);
    for (int k = 0; k < 4; ++k) {
      const bool there = k < branches;
      CHECK_EQUAL(there, file.find(fmt::format("[r{}]", k + 1)) != std::string::npos);
      CHECK_EQUAL(there, file.find(fmt::format("[tau{}]", k + 1)) != std::string::npos);
      CHECK_EQUAL(there, json.find(fmt::format("\"r{}_ohm\"", k + 1)) != std::string::npos);
      CHECK_EQUAL(there, json.find(fmt::format("\"tau{}_s\"", k + 1)) != std::string::npos);
      const double fitted = there ? std::max(1e-7, model.r(8, k + 1)) : 0.0;
      DOUBLES_EQUAL(fitted, p.r_ohm[static_cast<std::size_t>(k)], 1e-5 * fitted);
    }
  }
}

TEST(CellIdentification, TestsAtTwoTemperaturesBecomeATable) {
  options.tables = IdentifyOptions::Tables::kByTest;
  const CellLog log = cell.record(cell.pulse_plan(33.0, 500, 0.0));
  CellLog cold = log;
  for (std::size_t row = 0; row < cold.rows(); ++row) cold.voltage_v[row] -= 1e-3 * cold.current_a[row];
  const CellIdentification identified = identify_cell({log, cold}, {25.0, 10.0}, options);
  LONGS_EQUAL(2, identified.points.size());
  DOUBLES_EQUAL(25.0, identified.reference_point().temperature_c, 0.0);
  const CellTables tables(written_and_read(identified));
  const double warm = tables.circuit(0.5, 25.0, 33.0).r0_ohm, middle = tables.circuit(0.5, 17.5, 33.0).r0_ohm;
  DOUBLES_EQUAL(1e-3, tables.circuit(0.5, 10.0, 33.0).r0_ohm - warm, 5e-5);
  // Between the two by Arrhenius: ln R straight over 1/T.
  const double cold_ohm = tables.circuit(0.5, 10.0, 33.0).r0_ohm;
  const double share = (1.0 / 290.65 - 1.0 / 298.15) / (1.0 / 283.15 - 1.0 / 298.15);
  DOUBLES_EQUAL(1.0, middle / (warm * std::pow(cold_ohm / warm, share)), 2e-3);
}

TEST(CellIdentification, TestsOfSeveralCurrentsDivideALagAmongTheSameTimeConstants) {
  // Three lags for two branches, the third larger at low currents: each test alone finds another compromise, and a
  // table of both would charge one branch and discharge the other.
  const auto tested = [&](double current_a, double third_ohm) {
    CellLog log = cell.record(cell.pulse_plan(current_a, 400, 0.3));
    double third = 0.0;
    for (std::size_t row = 1; row < log.rows(); ++row) {
      const double keep = std::exp(-1.0 / 4.0);
      third = keep * third + (1.0 - keep) * third_ohm * log.current_a[row];
      log.voltage_v[row] -= third;
    }
    return log;
  };
  options.capacity_ah = cell.capacity_ah;
  std::vector<IdentificationProblem> ready;
  ready.emplace_back(std::vector<CellLog>{tested(15.0, 3e-3)}, options);
  ready.emplace_back(std::vector<CellLog>{tested(90.0, 0.0)}, options);
  const auto together = common_time_constants(ready, {25.0, 25.0}, 2);
  CHECK((together[0] - together[1]).norm() == 0.0);
  const auto alone = [&](std::size_t k) {
    std::vector<IdentificationProblem> one;
    one.push_back(std::move(ready[k]));
    return common_time_constants(one, {25.0}, 2)[0](0);
  };
  const double slow = alone(0), fast = alone(1);
  CHECK(std::max(slow, fast) > 1.5 * std::min(slow, fast));
  CHECK(together[0](0) > std::min(slow, fast) && together[0](0) < std::max(slow, fast));
}

TEST(CellIdentification, TimeConstantsOfAllTestsChangeWithTemperatureAlike) {
  const CellLog log = cell.record(cell.pulse_plan(33.0, 500, 0.3));
  std::vector<IdentificationProblem> ready;
  for (int k = 0; k < 3; ++k) ready.emplace_back(std::vector<CellLog>{log}, options);
  const auto found = common_time_constants(ready, {10.0, 25.0, 40.0}, 2);
  for (Eigen::Index branch = 0; branch < 2; ++branch) {
    // No change with temperature in these tests: none is found.
    DOUBLES_EQUAL(1.0, found[0](branch) / found[2](branch), 0.1);
  }
  const double ratio = std::log(found[0](0) / found[1](0));
  DOUBLES_EQUAL(ratio, std::log(found[0](1) / found[1](1)), 1e-9);
}

TEST(CellIdentification, ACellFileSaysWhichTimeConstantsItsTestsHaveTogether) {
  options.branches = 0;
  options.tables = IdentifyOptions::Tables::kByTest;
  const CellIdentification identified = identify_cell(
      {cell.record(cell.pulse_plan(33.0, 400, 0.3)), cell.record(cell.pulse_plan(99.0, 400, 0.3))}, {25.0, 25.0},
      options);
  STRCMP_CONTAINS("looked for in all 2 tests together",
                  fmt::format("{}", fmt::join(identified.reference_point().result.notes, "\n")).c_str());
  // How the number of branches was chosen stays told.
  CHECK(identified.reference_point().result.orders.size() >= 2);
}

TEST(CellIdentification, ASlowDischargeJoinsThePulsesInsteadOfBeingATestOfItsOwn) {
  cell.noise_v = 3e-4;
  std::vector<double> slow(600, 0.0);
  slow.insert(slow.end(), static_cast<std::size_t>(15.0 * 3600.0), cell.capacity_ah / 15.0);
  slow.insert(slow.end(), 600, 0.0);
  options.branches = 0;
  const CellIdentification identified =
      identify_cell({cell.record(cell.pulse_plan(33.0, 640, 0.02)), cell.record(slow)}, {26.0, 25.0}, options);
  LONGS_EQUAL(1, identified.points.size());
  DOUBLES_EQUAL(26.0, identified.points[0].temperature_c, 0.0);
  LONGS_EQUAL(2, identified.points[0].logs.size());
  const CircuitModel& model = identified.points[0].result.model;
  LONGS_EQUAL(2, model.branches());
  for (Eigen::Index node = 2; node < model.grid.size() - 1; ++node)
    DOUBLES_EQUAL(1.0, model.r0_ohm(node, 33.0) / KnownCell::r0(model.grid.at(node)), 0.02);
}

TEST(CellIdentification, OcvOfEachTestIsInTheFileBesideTheCurve) {
  options.tables = IdentifyOptions::Tables::kByTest;
  const CellLog log = cell.record(cell.pulse_plan(33.0, 500, 0.0));
  CellLog cold = log;
  for (double& v : cold.voltage_v) v -= 0.02;
  const CellIdentification identified = identify_cell({log, cold}, {25.0, 10.0}, options);
  const CellParameters read = written_and_read(identified);
  LONGS_EQUAL(2 * read.soc_breakpoints.size(), read.ocv_table_v.size());
  for (std::size_t soc = 5; soc < read.soc_breakpoints.size(); ++soc)
    DOUBLES_EQUAL(0.02, read.ocv_table_v[2 * soc + 1] - read.ocv_table_v[2 * soc], 2e-3);
}

TEST(CellIdentification, PlaceWithoutATestIsFilledFromItsNeighbourInCurrent) {
  options.tables = IdentifyOptions::Tables::kByTest;
  const CellLog low = cell.record(cell.pulse_plan(20.0, 500, 0.0)),
                high = cell.record(cell.pulse_plan(60.0, 500, 0.0));
  const CellIdentification identified = identify_cell({low, high, low}, {25.0, 25.0, 40.0}, options);
  LONGS_EQUAL(2, identified.temperatures_c.size());
  LONGS_EQUAL(2, identified.currents_a.size());
  CHECK(identified.was_tested(0, 1));
  CHECK(!identified.was_tested(1, 1));
  DOUBLES_EQUAL(40.0, identified.at(1, 1).temperature_c, 0.0);
  DOUBLES_EQUAL(20.0, identified.at(1, 1).current_a, 0.0);
  const CellParameters read = written_and_read(identified);
  LONGS_EQUAL(16 * 2 * 2, read.branches[0].r_ohm.table.size());
  STRCMP_CONTAINS("\"filled\"", identification_json(read, body_of(identified), identified, "0").c_str());
}
