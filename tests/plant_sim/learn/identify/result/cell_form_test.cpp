// SPDX-License-Identifier: Apache-2.0
#include "learn/identify/result/cell_form.hpp"

#include <fmt/format.h>

#include <numbers>
#include <random>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(CellForm){};

TEST(CellForm, NamesAndNumbersGiveTheSameCylinder) {
  for (const char* text : {"21700", "21.7x70.2", "21.7x70.2mm", "21.7X70.2"}) {
    const CellForm form = cell_form(text);
    CHECK_TEXT(form.is_cylinder(), text);
    DOUBLES_EQUAL(21.7, form.sides_mm[0], 0.0);
    DOUBLES_EQUAL(70.2, form.sides_mm[1], 0.0);
  }
  STRCMP_EQUAL("21700, a cylinder of 21.7 mm x 70.2 mm", cell_form("21700").text().c_str());
  STRCMP_EQUAL("a box of 127.5 mm x 42 mm x 10.7 mm", cell_form("127.5x42x10.7").text().c_str());
}

TEST(CellForm, SurfaceAndVolumeAreThoseOfTheSolid) {
  const CellForm cylinder = cell_form("20x70"), box = cell_form("128x42x10");
  DOUBLES_EQUAL(std::numbers::pi * (0.02 * 0.07 + 2.0 * 0.01 * 0.01), cylinder.surface_m2(), 1e-12);
  DOUBLES_EQUAL(std::numbers::pi * 0.01 * 0.01 * 0.07, cylinder.volume_m3(), 1e-15);
  DOUBLES_EQUAL(2.0 * (0.128 * 0.042 + 0.042 * 0.01 + 0.01 * 0.128), box.surface_m2(), 1e-12);
  DOUBLES_EQUAL(0.128 * 0.042 * 0.01, box.volume_m3(), 1e-15);
}

TEST(CellForm, MoreOfAnySideIsMoreSurfaceAndMoreVolume) {
  std::random_device device;
  const unsigned seed = device();
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> side(12.0, 300.0);
  for (int draw = 0; draw < 500; ++draw) {
    const double a = side(random), b = side(random), c = std::min(side(random), 60.0);
    const CellForm box = cell_form(fmt::format("{}x{}x{}", a, b, c));
    const CellForm longer = cell_form(fmt::format("{}x{}x{}", a + 1.0, b, c));
    const CellForm round = cell_form(fmt::format("{}x{}", c, c + b));
    const CellForm wider = cell_form(fmt::format("{}x{}", c + 1.0, c + b + 1.0));
    const std::string words = fmt::format("seed {}, draw {}", seed, draw);
    CHECK_TEXT(longer.volume_m3() > box.volume_m3() && longer.surface_m2() > box.surface_m2(), words.c_str());
    CHECK_TEXT(wider.volume_m3() > round.volume_m3() && wider.surface_m2() > round.surface_m2(), words.c_str());
    // A cylinder has pi/4 of its box.
    const CellForm around = cell_form(fmt::format("{}x{}x{}", c, c, c + b));
    DOUBLES_EQUAL_TEXT(std::numbers::pi / 4.0, round.volume_m3() / around.volume_m3(), 1e-12, words.c_str());
  }
}

TEST(CellForm, WhatIsNoSizeIsRefusedWithWhatToDo) {
  struct Case {
    const char *text, *words;
  };
  for (const auto& [text, words] : {Case{"", "18650, 21700, 26650"}, {"18651", "DIAMETERxLENGTH"},
                                    {"18x", "in mm"}, {"18xx65", "in mm"}, {"-18x65", "in mm"}, {"nanx65", "in mm"},
                                    {"18x65x1x2", "in mm"}, {"18x65cm", "in mm"}, {"0.0184x0.065", "Millimetres"},
                                    {"70x21", "wider than it is long"}, {"127x42", "wider than it is long"},
                                    {"2000x2000x2000", "Millimetres"}}) {
    const std::string said = complaint([&text = text] { (void)cell_form(text); });
    STRCMP_CONTAINS("--size", said.c_str());
    STRCMP_CONTAINS(words, said.c_str());
  }
}
