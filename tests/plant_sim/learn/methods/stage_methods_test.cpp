// SPDX-License-Identifier: Apache-2.0
#include "learn/methods/stage_methods.hpp"

#include <cmath>
#include <map>
#include <numeric>

#include "core/errors.hpp"
#include "learn/identify/cell_identification.hpp"
#include "learn/identify/result/excitation.hpp"
#include "learn/methods/method_comparison.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

/// Every method on one test of a known cell; computed once for all tests here.
const std::map<std::string, MethodScore>& scores() {
  static const std::map<std::string, MethodScore> all = [] {
    KnownCell cell;
    cell.noise_v = 5e-4;
    const CellLog log = cell.record(cell.pulse_plan(33.0, 900, 0.0));
    std::map<std::string, MethodScore> out;
    const auto add = [&](const std::string& name, std::optional<Method> method) {
      IdentifyOptions options;
      options.branches = 2;
      options.method = method;
      out[name] = method_score(name, {identify_cell({log}, {30.0}, options)});
    };
    for (const Method method : kMethods) add(name_of(method), method);
    add("full", std::nullopt);
    return out;
  }();
  return all;
}

}  // namespace

TEST_GROUP(StageMethods) {
  [[nodiscard]] static const MethodScore& of(const char* name) { return scores().at(name); }
};

TEST(StageMethods, NoiseOfTheInstrumentIsReadFromTheRests) {
  DOUBLES_EQUAL(2.5e-7, of("full").noise_floor_v2, 0.15e-7);
}

TEST(StageMethods, FullFitsReachTheNoiseOfTheInstrument) {
  CHECK(of("full").whole_mean_v2 < 1.3 * of("full").noise_floor_v2);
  CHECK(of("ffo").whole_mean_v2 < 1.3 * of("ffo").noise_floor_v2);
}

TEST(StageMethods, FreeingMoreOfAPulseLowersItsErrorAndOneValueANodeRaisesIt) {
  CHECK(of("fpo").mean_v2 < of("ipo").mean_v2);
  CHECK(of("flo").mean_v2 < of("ilo").mean_v2);
  CHECK(of("ilo").mean_v2 > of("fpo").mean_v2);
  CHECK(of("flo").mean_v2 > of("fpo").mean_v2);
}

TEST(StageMethods, OnlyTheFullFitFollowsTheWholeTest) {
  for (const char* name : {"ipo", "fpo", "ilo", "flo"})
    CHECK(of(name).whole_mean_v2 > 3.0 * of("ffo").whole_mean_v2);
  DOUBLES_EQUAL(1.0, of("full").whole_mean_v2 / of("ffo").whole_mean_v2, 0.05);
}

TEST(StageMethods, PulsesThatFitBestByThemselvesFitTogetherWorst) {
  CHECK(of("fpo").mean_v2 < 1.3 * of("fpo").noise_floor_v2);
  for (const char* name : {"ipo", "ilo", "flo"}) CHECK(of("fpo").whole_mean_v2 > 5.0 * of(name).whole_mean_v2);
}

TEST(StageMethods, EachMethodGivesAModelWithoutIntervals) {
  KnownCell cell;
  IdentifyOptions options;
  options.branches = 2;
  options.method = Method::kFinalLayered;
  const IdentifyResult result = identify({cell.record(cell.pulse_plan(33.0, 900, 0.0))}, options);
  LONGS_EQUAL(16, result.model.r.rows());
  DOUBLES_EQUAL(1.0, result.model.r(8, 0) / KnownCell::r0(0.5), 0.03);
  DOUBLES_EQUAL(KnownCell::em(0.5), result.model.ocv.value(result.model.em, 0.5), 5e-3);
  CHECK(std::isnan(result.uncertainty.sigma(0)));
  CHECK_FALSE(is_excited(result, 0, 8));
}

TEST(StageMethods, PulseMethodRefusesBlocksAndAnOcv) {
  KnownCell cell;
  IdentifyOptions options;
  options.method = Method::kInitialPulse;
  options.block_s = 60.0;
  CHECK_THROWS(InputError, identify({cell.record(cell.pulse_plan(33.0, 900, 0.0))}, options));
}

TEST(StageMethods, NamesAreThoseOfTheStudy) {
  for (const Method method : kMethods) {
    CHECK(method_of(name_of(method)) == method);
    CHECK(study_score(name_of(method)) != nullptr);
  }
  CHECK_FALSE(method_of("full").has_value());
  CHECK(study_score("full") == nullptr);
}
