// SPDX-License-Identifier: Apache-2.0
#include "race/report/cell_temperature_curves.hpp"

#include <nlohmann/json.hpp>

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

nlohmann::ordered_json curves_of(std::size_t cells, int samples) {
  CellTemperatureCurves curves;
  for (int k = 0; k < samples; ++k) {
    std::vector<double> temperature_c(cells);
    for (std::size_t cell = 0; cell < cells; ++cell) temperature_c[cell] = 20.0 + 1e-3 * k + static_cast<double>(cell);
    curves.add(0.1 * (k + 1), temperature_c);
  }
  return curves.json();
}

std::size_t bytes(const nlohmann::ordered_json& curves) { return curves.dump().size(); }

}  // namespace

TEST_GROUP(CellTemperatureCurves){};

TEST(CellTemperatureCurves, AShortRunKeepsEverySample) {
  const auto curves = curves_of(3, 10);
  LONGS_EQUAL(10, curves["samples"].get<int>());
  LONGS_EQUAL(3, curves["columns"].size());
  DOUBLES_EQUAL(0.1, curves["first_s"].get<double>(), 1e-12);
  DOUBLES_EQUAL(0.1, curves["period_s"].get<double>(), 1e-12);
}

TEST(CellTemperatureCurves, ALongRunIsThinnedEvenlyAndSaysSo) {
  const auto curves = curves_of(24, 20'000);
  LONGS_EQUAL(1'250, curves["samples"].get<int>());
  DOUBLES_EQUAL(1.6, curves["period_s"].get<double>(), 1e-12);
}

TEST(CellTemperatureCurves, HoweverManyCellsAndHoursThePageStaysSmall) {
  for (const std::size_t cells : {1, 24, 96, 144}) {
    const auto curves = curves_of(cells, 45'000);
    CHECK(curves["samples"].get<std::size_t>() <= CellTemperatureCurves::kSamplesMax);
    CHECK(curves["samples"].get<std::size_t>() * cells <= CellTemperatureCurves::kValuesMax);
    CHECK(bytes(curves) < 400'000);
  }
}

TEST(CellTemperatureCurves, ARunWithoutSamplesHasNone) {
  LONGS_EQUAL(0, CellTemperatureCurves().json()["samples"].get<int>());
  CHECK(CellTemperatureCurves().json()["columns"].empty());
}
