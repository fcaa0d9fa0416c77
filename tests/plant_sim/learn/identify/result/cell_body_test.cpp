// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_body.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <random>

#include "core/parameter_file.hpp"
#include "learn/identify/result/cell_file.hpp"
#include "learn/identify/result/cell_parameters.hpp"
#include "learn/identify/result/identify_text.hpp"
#include "plant_sim/core/scratch.hpp"
#include "plant_sim/learn/identify/known_cell.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

CellParameters shipped(const std::string& name) { return load_cell(DataFolder{VOLTLAP_DATA_FOLDER}, name, "test"); }

/// Identified once: fits take their time, and here only the body differs.
const CellIdentification& identified() {
  static const CellIdentification once = [] {
    const KnownCell cell;
    IdentifyOptions options;
    options.branches = 2;
    return identify_cell({cell.record(cell.pulse_plan(33.0, 500, 0.0))}, {30.0}, options);
  }();
  return once;
}

bool has(const std::vector<std::string>& lines, const char* words) {
  return std::any_of(lines.begin(), lines.end(),
                     [&](const std::string& line) { return line.find(words) != std::string::npos; });
}

}  // namespace

TEST_GROUP(CellBody) {
  Scratch scratch;
  std::vector<std::string> notes;

  CellParameters made(const CellBody& body) { return cell_parameters(identified(), body, "known", notes); }
  CellParameters written_and_read(const CellBody& body) {
    return load_cell(DataFolder{VOLTLAP_DATA_FOLDER},
                     scratch.write("known.toml", cell_toml(made(body), body, identified())), "test");
  }
};

TEST(CellBody, WhatWasToldIsWhatTheWrittenFileHas) {
  std::random_device device;
  const unsigned seed = device();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> mass(0.015, 3.0), edge(9.0, 250.0), heat(600.0, 1300.0);  // above 0.5 cm3
  for (int draw = 0; draw < 100; ++draw) {
    const double a = edge(random), b = edge(random), c = edge(random);
    const std::string size = draw % 2 == 0 ? fmt::format("{:.4g}x{:.4g}x{:.4g}", a, b, std::min(c, 60.0))
                                           : fmt::format("{:.4g}x{:.4g}", std::min(a, b), std::max(a, b));
    const ToldBody told{mass(random), cell_form(size), heat(random)};
    const CellParameters read = written_and_read(cell_body(told, {30.0}, shipped));
    const std::string words = fmt::format("seed {}, draw {}: {}", seed, draw, size);
    const double exact = 1e-5;  // six digits in the file
    DOUBLES_EQUAL_TEXT(1.0, read.mass_kg / *told.mass_kg, exact, words.c_str());
    DOUBLES_EQUAL_TEXT(1.0, read.surface_area_m2 / told.form->surface_m2(), exact, words.c_str());
    DOUBLES_EQUAL_TEXT(1.0, read.heat_capacity_j_per_kg_k / *told.heat_capacity_j_per_kg_k, exact, words.c_str());
  }
}

TEST(CellBody, EachThatIsNotToldIsAssumedAndCanBeRead) {
  for (int told_bits = 0; told_bits < 8; ++told_bits) {
    ToldBody told;
    if (told_bits & 1) told.mass_kg = 0.61;
    if (told_bits & 2) told.form = cell_form("227x160x7.2");
    if (told_bits & 4) told.heat_capacity_j_per_kg_k = 950.0;
    const CellBody body = cell_body(told, {30.0}, shipped);
    CHECK_EQUAL((told_bits & 1) != 0, body.mass.origin == FactOrigin::kTold);
    CHECK_EQUAL((told_bits & 2) != 0, body.surface.origin == FactOrigin::kTold);
    CHECK_EQUAL((told_bits & 4) != 0, body.heat_capacity.origin == FactOrigin::kTold);
    const CellParameters read = written_and_read(body);
    CHECK(read.mass_kg > 0.0 && read.surface_area_m2 > 0.0);
    // What was told is named as told, what was not is asked for: each flag once.
    const std::string text = cell_facts_text(read, body, true);
    for (const char* flag : {"--mass", "--heat-capacity"}) {
      const std::size_t first = text.find(flag);
      CHECK(first != std::string::npos && text.find(flag, first + 1) == std::string::npos);
    }
  }
}

TEST(CellBody, ACellThatIsNotToldHasTheFormOfItsCapacity) {
  struct Case {
    double capacity_ah;
    const char *form, *like;
  };
  for (const auto& [capacity_ah, form, like] : {Case{2.0, "18650", "molicel_p42a"}, {3.4, "18650", "molicel_p42a"},
                                                {4.5, "21700", "molicel_p42a"}, {6.0, "21700", "molicel_p42a"},
                                                {6.6, "a pouch", "melasta"}, {30.0, "a pouch", "aesc"}}) {
    const CellBody body = cell_body({}, {capacity_ah}, shipped);
    STRCMP_CONTAINS(form, body.form_text().c_str());
    STRCMP_CONTAINS(like, body.heat_capacity.source.c_str());
    STRCMP_CONTAINS("mostly", body.form_source.c_str());
    CHECK(body.form_origin == FactOrigin::kAssumed && body.surface.origin == FactOrigin::kAssumed);
  }
  // The shipped cells of that form weigh that.
  for (const char* name : {"samsung_30q", "sony_vtc6", "molicel_p42a", "lg_m50lt", "melasta_slpbb042126"}) {
    const CellParameters cell = shipped(name);
    const CellBody body = cell_body({}, {cell.capacity_ah}, shipped);
    DOUBLES_EQUAL_TEXT(1.0, body.mass.value / cell.mass_kg, 0.05, name);
    DOUBLES_EQUAL_TEXT(1.0, body.surface.value / cell.surface_area_m2, 0.03, name);
  }
}

TEST(CellBody, AMassThatIsToldDecidesTheForm) {
  const auto form = [](double mass_kg, double capacity_ah) {
    const ToldBody told{.mass_kg = mass_kg, .form = {}, .heat_capacity_j_per_kg_k = {}};
    return cell_body(told, {capacity_ah}, shipped).form_text();
  };
  STRCMP_CONTAINS("21700", form(0.07, 3.0).c_str());
  STRCMP_CONTAINS("26650", form(0.09, 5.0).c_str());
  STRCMP_EQUAL("a pouch", form(0.12, 5.0).c_str());
  STRCMP_EQUAL("a pouch", form(0.07, 8.0).c_str());
}

TEST(CellBody, HeavierAndLargerIsNeverLess) {
  std::random_device device;
  const unsigned seed = device();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> capacity(6.1, 60.0), mass(0.12, 3.0), more(1.001, 2.0);
  for (int draw = 0; draw < 200; ++draw) {
    const double ah = capacity(random), kg = mass(random), by = more(random);
    const std::string words = fmt::format("seed {}, draw {}: {} Ah, {} kg, times {}", seed, draw, ah, kg, by);
    const auto body = [&](std::optional<double> told, double of_ah) {
      return cell_body({.mass_kg = told, .form = {}, .heat_capacity_j_per_kg_k = {}}, {of_ah}, shipped);
    };
    CHECK_TEXT(body(kg * by, ah).surface.value > body(kg, ah).surface.value, words.c_str());
    const bool same_model = (ah < 19.0) == (ah * by < 19.0);
    CHECK_TEXT(!same_model || body({}, ah * by).mass.value > body({}, ah).mass.value, words.c_str());
  }
}

TEST(CellBody, WhatNoCellHasIsSaid) {
  const auto said = [&](double mass_kg, const char* size) {
    notes.clear();
    const ToldBody told{.mass_kg = mass_kg, .form = cell_form(size), .heat_capacity_j_per_kg_k = {}};
    (void)made(cell_body(told, {30.0}, shipped));
    return notes;
  };
  CHECK_FALSE(has(said(0.6, "227x160x7.2"), "Implausible"));  // 2290 kg/m3, 180 Wh/kg
  CHECK(has(said(2.0, "227x160x7.2"), "7648 kg/m3"));
  CHECK(has(said(0.3, "227x160x7.2"), "1147 kg/m3"));
  CHECK(has(said(0.2, "227x160x7.2"), "Wh/kg"));
  CHECK(has(said(7.0, "227x160x80"), "Wh/kg"));
}

TEST(CellBody, TheSummarySaysOfEachNumberWhetherItWasToldMeasuredOrAssumed) {
  const CellBody body = cell_body({.mass_kg = 0.6, .form = {}, .heat_capacity_j_per_kg_k = {}}, {30.0}, shipped);
  const std::string text = identification_text(made(body), body, identified(), 1);
  for (const char* words : {"0.6 kg      told      --mass", "Ah      measured  identified", "W/m2/K  assumed",
                            "tell it with --size, --heat-capacity", "battery.convection_w_per_m2_k"}) {
    STRCMP_CONTAINS(words, text.c_str());
  }
  const std::string untold = cell_facts_text(made(body), body, false);
  STRCMP_CONTAINS("degC    assumed   neither recorded nor told", untold.c_str());
  STRCMP_CONTAINS("mass_kg = 0.6  # kg; told: --mass", cell_toml(made(body), body, identified()).c_str());
  STRCMP_CONTAINS("\"origin\": \"told\"", identification_json(made(body), body, identified(), "0").c_str());
}

TEST(CellBody, APartOfADischargeMakesNoPouchOfA18650) {
  const auto form = [&](double ah, CapacityFrom from) { return cell_body({}, {ah, from}, shipped).form_text(); };
  for (const double drawn : {0.05, 0.8, 2.9}) STRCMP_CONTAINS("18650", form(drawn, CapacityFrom::kDrawnOnly).c_str());
  STRCMP_CONTAINS("a pouch", form(0.8, CapacityFrom::kWholeDischarge).c_str());
  STRCMP_CONTAINS("a pouch", form(9.0, CapacityFrom::kDrawnOnly).c_str());
  const CellBody body = cell_body({}, {0.8, CapacityFrom::kDrawnOnly}, shipped);
  STRCMP_CONTAINS("at least 0.8 Ah", body.form_source.c_str());
  DOUBLES_EQUAL(0.0464, body.mass.value, 1e-4);
  CellParameters cell = made(body);
  cell.capacity_ah = 0.05;
  CHECK(implausible(cell, body).empty());
}

TEST(CellBody, TheCapacitySaysWhereItIsFrom) {
  const auto fact = [&](CapacityFrom from) { return cell_body({}, {30.0, from, 0.4}, shipped).capacity; };
  CHECK(fact(CapacityFrom::kTold).origin == FactOrigin::kTold);
  CHECK(fact(CapacityFrom::kWholeDischarge).origin == FactOrigin::kMeasured);
  CHECK(fact(CapacityFrom::kDrawnOnly).origin == FactOrigin::kAssumed);
  STRCMP_CONTAINS("--capacity AH", fact(CapacityFrom::kDrawnOnly).source.c_str());
  STRCMP_CONTAINS("+- 0.4 Ah", fact(CapacityFrom::kRestsAndOcv).source.c_str());
}
