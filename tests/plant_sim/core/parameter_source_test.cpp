// SPDX-License-Identifier: Apache-2.0
#include "core/parameter_source.hpp"

#include <algorithm>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP(ParameterSource) {
  Scratch scratch;
  DataFolder data{VOLTLAP_SOURCE_DIR "/plant_sim/data"};

  ParameterSource source(const std::string& key, const std::string& vehicle = "vtm16e",
                         const std::vector<std::string>& settings = {}) {
    const auto all = parameter_sources(load_vehicle(data, vehicle, settings));
    const auto found =
        std::find_if(all.begin(), all.end(), [&](const ParameterSource& one) { return one.key == key; });
    return found == all.end() ? ParameterSource{} : *found;
  }
};

TEST(ParameterSource, ANumberOfAFileHasThePlaceAndTheCommentBehindIt) {
  const ParameterSource mass = source("vehicle.mass_kg");
  STRCMP_EQUAL("243", mass.value.c_str());
  STRCMP_EQUAL("kg", mass.unit.c_str());
  STRCMP_CONTAINS("vtm16e.toml:", mass.place.c_str());
  STRCMP_EQUAL("reference study, Table B.3", mass.source.c_str());
  CHECK(!mass.meaning.empty());
}

TEST(ParameterSource, ASettingSaysSo) {
  const ParameterSource mass = source("vehicle.mass_kg", "vtm16e", {"vehicle.mass_kg=230"});
  STRCMP_EQUAL("230", mass.value.c_str());
  STRCMP_EQUAL("--set", mass.place.c_str());
  STRCMP_EQUAL("", mass.source.c_str());
}

TEST(ParameterSource, AKeyThatNobodyGaveIsADefault) {
  STRCMP_EQUAL("default", source("cell.r0.table").place.c_str());
}

TEST(ParameterSource, OneNumberUnderTwoKeysHasOneSource) {
  STRCMP_CONTAINS("aesc_e5_2p.toml:", source("battery.capacity_ah").place.c_str());
  STRCMP_EQUAL("--set", source("cell.capacity_ah", "vtm16e", {"battery.capacity_ah=50"}).place.c_str());
  STRCMP_EQUAL("50", source("cell.capacity_ah", "vtm16e", {"battery.capacity_ah=50"}).value.c_str());
}

TEST(ParameterSource, ASingleCellsKeyHasItsUnitAndMeaning) {
  const ParameterSource scale =
      source("battery.cells.7.capacity_scale", "vtm16e", {"battery.cells.7.capacity_scale=0.9"});
  STRCMP_EQUAL("0.9", scale.value.c_str());
  STRCMP_EQUAL("1", scale.unit.c_str());
  CHECK(!scale.meaning.empty());
}

TEST(ParameterSource, AHashInsideQuotesIsNoComment) {
  const std::string file = scratch.write(
      "car.toml", "base = \"vtm16e\"\nname = \"car\"\n[powertrain]\nkind = \"none\"  # -; by hand # twice\n");
  STRCMP_EQUAL("by hand # twice", source("powertrain.kind", file).source.c_str());
  const std::string cell = VOLTLAP_SOURCE_DIR "/plant_sim/data/cells/aesc_e5_2p.toml";
  std::filesystem::copy_file(cell, scratch.file("a#b.toml"));
  const std::string odd = scratch.write("odd.toml", "base = \"vtm16e\"\n[battery]\ncell = \"a#b.toml\"  # mine\n");
  STRCMP_EQUAL("mine", source("battery.cell", odd).source.c_str());
}
