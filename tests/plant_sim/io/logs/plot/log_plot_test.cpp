// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/log_plot.hpp"

#include <fmt/format.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

nlohmann::json data_of(const std::string& page) {
  const std::string mark = "id=\"voltlap-data\">";
  const std::size_t begin = page.find(mark) + mark.size();
  return nlohmann::json::parse(page.substr(begin, page.find("</script>", begin) - begin));
}

bool contains(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

}  // namespace

TEST_GROUP(LogPlot) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  LogPlotRequest request{
      "drive.csv", {}, {}, {}, "1.0", "voltlap log plot drive.csv", [](const std::string&, double) {}};

  std::string drive(int rows) const {
    std::string text = "t_s,pack_v,cell_v,count,<b>\n";
    for (int i = 0; i < rows; ++i) {
      const double v = 400.0 - 20.0 * std::sin(0.01 * i);
      text += fmt::format("{:.2f},{:.1f},{:.4f},{},{}\n", 0.01 * i, v, v / 100.0, i % 16, i == rows / 2 ? 99 : i % 3);
    }
    return scratch.write("drive.csv", text);
  }
  LogPlot plot(int rows = 2000) { return plot_log(*open_signals({drive(rows), {}, {}}, data), request); }
};

TEST(LogPlot, ThePageHasAChartForEachUnitAndSizeAndATableOfAllSignals) {
  const LogPlot found = plot();
  const auto charts = data_of(found.page)["charts"];
  LONGS_EQUAL(3, charts.size());
  STRCMP_EQUAL("V", charts[0]["unit"].get<std::string>().c_str());
  STRCMP_CONTAINS("Voltage, 380 to 420 V", charts[0]["title"].get<std::string>().c_str());
  CHECK(contains(found.page, "<th scope=\"row\">count</th><td></td>"));
  CHECK(contains(found.page, "<th scope=\"row\">pack_v</th><td>drawn</td><td>V</td>"));
  CHECK(contains(found.page, "1 are counters or checksums"));
}

TEST(LogPlot, NamesFromTheRecordingAreTextNotMarkup) {
  const std::string page = plot().page;
  CHECK(contains(page, "<th scope=\"row\">&lt;b&gt;</th>"));
  CHECK_FALSE(contains(page, "\"<b>\""));
}

TEST(LogPlot, AStretchIsShownWithTheRecordingsOwnTimes) {
  request.from_s = 5.0;
  request.to_s = 7.5;
  request.signals = {"pack_v"};
  const auto shown = data_of(plot().page);
  DOUBLES_EQUAL(5.0, shown["begin_s"].get<double>(), 1e-9);
  DOUBLES_EQUAL(7.5, shown["end_s"].get<double>(), 1e-9);
  DOUBLES_EQUAL(5.0, shown["charts"][0]["series"][0]["first_s"].get<double>(), 1e-9);
}

TEST(LogPlot, AStretchWithoutASampleIsRefused) {
  request.from_s = 5000.0;
  STRCMP_CONTAINS("no value in that stretch", complaint([&] { plot(); }).c_str());
  request.to_s = 4000.0;
  STRCMP_CONTAINS("not after --from", complaint([&] { plot(); }).c_str());
}

TEST(LogPlot, ALongRecordingMakesASmallPageThatKeepsItsSpike) {
  request.signals = {"*"};
  const LogPlot found = plot(200'000);
  CHECK(found.page.size() < 5'000'000);
  for (const auto& chart : data_of(found.page)["charts"]) {
    for (const auto& series : chart["series"]) {
      CHECK(series["points"].get<std::size_t>() <= 60'000);
      if (series["name"] == "<b>") STRCMP_EQUAL("0 … 99", series["range"].get<std::string>().c_str());
    }
  }
  CHECK(contains(found.page, "the lowest and the highest value of every"));
}
