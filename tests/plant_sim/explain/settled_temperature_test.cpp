// SPDX-License-Identifier: Apache-2.0
// How warm cells are believed to be where their model's heat is wrong.
#include "explain/model/settled_temperature.hpp"

#include <CppUTest/TestHarness.h>

#include <cmath>
#include <random>
#include <string>

#include "explain/balances/model.hpp"

namespace voltlap::explain {
namespace {

/// A cold cell under a drawn current, whose reversible heat the model does not have.
struct ColdCell {
  explicit ColdCell(unsigned seed) {
    model = plant::load_model(plant::DataFolder(VOLTLAP_DATA_FOLDER), "aesc_e5_2p", {}).world;
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> degrees(0.0, 15.0), amperes(60.0, 90.0), entropy(5e-4, 9e-4);
    const double cold_c = degrees(random);
    model.car.environment.ambient_c = model.car.battery.initial_temperature_c = cold_c;
    truth = model;
    truth.car.cell.effects.entropy_v_per_k += (seed % 2 == 0 ? 1.0 : -1.0) * entropy(random);
    constexpr Index kRows = 700;
    log.time_s = VectorXd::LinSpaced(kRows, 0.0, kRows - 1.0);
    log.signals["current"] = VectorXd::Constant(kRows, amperes(random));
    log.signals["current"].head(30).setZero();
    log.signals["voltage"] = VectorXd::Constant(kRows, 3.9);
    log.signals["temperature_1"] = VectorXd::Constant(kRows, cold_c);
    for (int round = 0; round < 5; ++round) {  // its voltage follows its temperature
      const plant::Comparison blank = plant::comparison_of(truth, log, {});
      const plant::Prediction made = plant::predict(truth, blank);
      log.signals["voltage"] = made.channels[0];
      log.signals["temperature_1"] = made.battery.surface_c;
    }
  }
  plant::World model, truth;
  plant::Recording log;
};

double most_off(const VectorXd& settled, const VectorXd& read) { return (settled - read).cwiseAbs().maxCoeff(); }

}  // namespace

TEST_GROUP(SettledTemperature){};

TEST(SettledTemperature, AtTheEndsOfALogItIsThatOfTheWorldThatIsBelieved) {
  for (unsigned seed = 1; seed <= 10; ++seed) {
    const ColdCell cell(seed);
    const VectorXd& read = cell.log.signals.at("temperature_1");
    const Observed seen = observed(cell.model, plant::comparison_of(cell.model, cell.log, {}));
    const double by_model = most_off(seen.comparison.facts.temperature_c, read);
    const double by_truth = most_off(facts_with(cell.truth, seen).temperature_c, read);
    CHECK_TEXT(by_model > 0.2, std::to_string(by_model).c_str());
    CHECK_TEXT(by_truth < 0.05, std::to_string(by_truth).c_str());
  }
}

TEST(SettledTemperature, OfTheModelItselfItIsWhatTheLogWasHeldWith) {
  const ColdCell cell(1);
  const Observed seen = observed(cell.model, plant::comparison_of(cell.model, cell.log, {}));
  const plant::LogFacts again = facts_with(cell.model, seen);
  DOUBLES_EQUAL(0.0, most_off(seen.comparison.facts.temperature_c, again.temperature_c), 1e-6);
  if (again.above_surface_k.size() > 0)
    DOUBLES_EQUAL(0.0, most_off(seen.comparison.facts.above_surface_k, again.above_surface_k), 1e-6);
}

}  // namespace voltlap::explain
