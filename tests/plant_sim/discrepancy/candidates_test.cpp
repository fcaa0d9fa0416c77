// SPDX-License-Identifier: Apache-2.0
// Which causes act on what all cells share, of which references tell least.
#include "discrepancy/candidates.hpp"

#include <map>

#include "discrepancy/causes/list.hpp"
#include "discrepancy/model.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST_GROUP(Candidates) {
  static constexpr Index kRows = 3000;  // 10 Hz

  struct Log {
    Design design;
    Usual usual;
    Score score;
    std::vector<Candidate> locals;
    std::vector<Cause> causes;
  };

  /// A pack of two cells whose terminals and charge are logged too.
  static Log two_cells() {
    World model = load_model(DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
    model.car.battery.cells_in_series = 2;
    Recording log;
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, 0.1 * (kRows - 1));
    const VectorXd wave = (0.7 * log.time_s.array()).sin();
    log.signals["current"] = 30.0 * wave;
    log.signals["current"].head(300).setZero();
    log.signals["cell_voltage_1"] = log.signals["cell_voltage_2"] = VectorXd::Constant(kRows, 3.9);
    log.signals["pack_voltage"] = VectorXd::Constant(kRows, 7.8);
    log.signals["soc"] = VectorXd::Constant(kRows, 0.5);
    const std::vector<Cause> causes = catalogue({});
    Design design = design_of(model, comparison_of(model, log, {.judge_soc = true}), causes);
    Usual usual;
    usual.inflation.assign(design.comparison.channels.size(), 1.0);
    for (const auto& shapes : design.shapes) {
      const auto n = static_cast<Index>(shapes.size());
      usual.group_mean.push_back(MatrixXd::Zero(n, 2));
      usual.group_variance.push_back(MatrixXd::Zero(n, n));
      usual.group_inflation.push_back(1.0);
    }
    const NoiseModel noise = noise_of({&design});
    std::vector<Candidate> locals = local_candidates(design, causes, group_scores(design, noise), usual);
    const auto columns = static_cast<Index>(design.columns.size());
    usual.mean = VectorXd::Zero(columns);
    usual.variance = MatrixXd::Zero(columns, columns);
    Score score = score_of(design, noise);
    return {std::move(design), usual, std::move(score), std::move(locals), causes};
  }

  /// By the name of the cause.
  static std::map<std::string, bool> of_all_cells() {
    const auto [design, usual, score, locals, causes] = two_cells();
    const System system = system_of(design, {}, score, usual, causes);
    std::map<std::string, bool> out;
    for (const Candidate& c : system.candidates) {
      const std::string name = c.cause < 0 ? "" : causes[static_cast<std::size_t>(c.cause)].name;
      out[name + c.channel] = c.of_all_cells;
    }
    return out;
  }
};

TEST(Candidates, WhatACellDiffersByFromDayToDayItDiffersByInTheMeanToo) {
  const auto [design, usual, score, locals, causes] = two_cells();
  Score means_alone = score;
  for (GroupScore& group : means_alone.groups) group.gram.setZero();
  Usual differs = usual;
  for (MatrixXd& variance : differs.group_variance) variance.diagonal().setOnes();
  const VectorXd known = system_of(design, locals, means_alone, usual, causes).information.diagonal();
  const VectorXd left = system_of(design, locals, means_alone, differs, causes).information.diagonal();
  int clear = 0;
  for (const Candidate& local : locals) {
    for (const Index row : local.rows) {
      if (!(known(row) > 1.0)) continue;
      CHECK(left(row) <= known(row) / (1.0 + known(row)) * (1.0 + 1e-6));
      ++clear;
    }
  }
  CHECK(clear > 0);
}

TEST(Candidates, WhatActsBetweenTwoSensorsIsNotOfAllCells) {
  const auto found = of_all_cells();
  for (const char* name : {"series_resistance", "capacity", "hysteresis", "initial_soc", "current_offset"}) {
    CHECK_TEXT(found.at(name), name);
  }
  for (const char* name : {"contact_resistance", "reported_voltage_compensation", "voltage_offsetpack_voltage"}) {
    CHECK_FALSE_TEXT(found.at(name), name);
  }
}
