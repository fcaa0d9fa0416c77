// SPDX-License-Identifier: Apache-2.0
#include "learn/bench/campaign_files.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <sstream>

#include "bench_fixtures.hpp"
#include "fixtures.hpp"
#include "io/table_file.hpp"
#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;
using namespace voltlap::plant::test;

namespace {

std::string text_of(const std::string& path) {
  std::ostringstream out;
  out << std::ifstream(path).rdbuf();
  return out.str();
}

}  // namespace

TEST_GROUP(CampaignFiles) {
  Scratch scratch;
  Campaign campaign{shipped_plan("random_resistors", {"load.resistors=[4, 2]"}), vtm16e().cell, 5};
  BenchRecord record = campaign.run(0);

  std::string write(const std::string& folder, bool gzip, const std::string& truth) const {
    CampaignFiles files(campaign, {folder, gzip, truth});
    files.add(record);
    const std::string index = files.index(forecast(campaign), {"load.resistors=[4, 2]"});
    files.commit(index);
    return index;
  }
};

TEST(CampaignFiles, EachCellHasAPlainTable) {
  const std::string folder = scratch.file("out");
  (void)write(folder, false, "");
  const InputTable table(folder + "/30c_random_cell3.csv");
  LONGS_EQUAL(5, table.columns().size());
  LONGS_EQUAL(record.time_s.size(), table.rows());
  for (const std::size_t row : {std::size_t{0}, std::size_t{70}, table.rows() - 1}) {
    DOUBLES_EQUAL(record.time_s[row], table.number(row, "time_s"), 0.0);
    DOUBLES_EQUAL(record.current_a[row], table.number(row, "current_a"), 5.1e-5);
    DOUBLES_EQUAL(record.cells[2].voltage_v[row], table.number(row, "voltage_v"), 5.1e-7);
    DOUBLES_EQUAL(record.cells[2].temperature_c[row], table.number(row, "temperature_c"), 5.1e-4);
    DOUBLES_EQUAL(record.ambient_c[row], table.number(row, "ambient_c"), 5.1e-4);
  }
}

TEST(CampaignFiles, FolderHoldsTheTablesAndTheIndexAndNothingElse) {
  (void)write(scratch.file("out"), true, "");
  std::size_t files = 0;
  for (const auto& entry : std::filesystem::directory_iterator(scratch.file("out"))) {
    const std::string name = entry.path().filename();
    CHECK(name == "campaign.json" || name.ends_with(".csv.gz"));
    ++files;
  }
  LONGS_EQUAL(5, files);
  LONGS_EQUAL(1, scratch.files());
}

TEST(CampaignFiles, TruthIsInItsOwnFileAndInTheIndexOnlyWhenAskedFor) {
  const auto hidden = nlohmann::json::parse(write(scratch.file("a"), false, ""));
  CHECK_FALSE(hidden.contains("truth"));
  CHECK_FALSE(hidden["tests"][0].contains("truth"));
  STRCMP_EQUAL("time_s,current_a,voltage_v,temperature_c,ambient_c",
               text_of(scratch.file("a/30c_random_cell1.csv"))
                   .substr(text_of(scratch.file("a/30c_random_cell1.csv")).find('\n') + 1, 50)
                   .c_str());

  const auto open = nlohmann::json::parse(write(scratch.file("b"), false, scratch.file("truth.csv")));
  DOUBLES_EQUAL(record.cells[1].capacity_ah, open["tests"][0]["truth"]["capacity_ah"][1].get<double>(), 1e-9);
  DOUBLES_EQUAL(campaign.errors().current_high_gain,
                open["truth"]["instruments"]["current_high_gain"].get<double>(), 1e-12);
  DOUBLES_EQUAL(55.2, open["truth"]["cell"]["capacity_ah"].get<double>(), 1e-9);
  const InputTable truth(scratch.file("truth.csv"));
  LONGS_EQUAL(record.time_s.size(), truth.rows());
  DOUBLES_EQUAL(record.cells[3].true_soc[100], truth.number(100, "cell_4_soc"), 1e-8);
  DOUBLES_EQUAL(record.cells[3].true_voltage_v[100], truth.number(100, "cell_4_voltage_v"), 1e-7);
}

TEST(CampaignFiles, IndexHasAllThatARepetitionNeeds) {
  const auto index = nlohmann::json::parse(write(scratch.file("out"), false, ""));
  LONGS_EQUAL(5, index["seed"].get<int>());
  STRCMP_EQUAL("random_resistors", index["plan"]["name"].get<std::string>().c_str());
  DOUBLES_EQUAL(60.0, index["plan"]["schedule.pulse_s"].get<double>(), 0.0);
  STRCMP_EQUAL("load.resistors=[4, 2]", index["settings"][0].get<std::string>().c_str());
  LONGS_EQUAL(4, index["tests"][0]["files"].size());
  DOUBLES_EQUAL(record.duration_s(), index["tests"][0]["duration_s"].get<double>(), 1e-9);
  LONGS_EQUAL(16, index["forecast"]["coverage"]["load_s"].size());
  LONGS_EQUAL(5, index["forecast"]["coverage"]["load_s"][0][2].size());
}

TEST(CampaignFiles, OneSeedWritesTheSameBytes) {
  CHECK(write(scratch.file("a"), false, "") == write(scratch.file("b"), false, ""));
  CHECK(text_of(scratch.file("a/30c_random_cell2.csv")) == text_of(scratch.file("b/30c_random_cell2.csv")));
}

TEST(CampaignFiles, AFolderThatCannotBeMadeIsAnError) {
  scratch.write("file", "");
  STRCMP_CONTAINS("--out", complaint([&] {
                             CampaignFiles files(campaign, {scratch.file("file/out"), false, ""});
                           }).c_str());
}
