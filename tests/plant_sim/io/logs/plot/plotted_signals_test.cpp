// SPDX-License-Identifier: Apache-2.0
#include "io/logs/plot/plotted_signals.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cmath>
#include <cstdlib>
#include <map>

#include "plant_sim/core/scratch.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

namespace {

const char* const kDbc =
    "BO_ 256 Bms: 8 X\n SG_ Voltage : 0|16@1+ (0.1,0) [0|1000] \"V\" X\n SG_ Current : 16|16@1- (0.1,0) [0|0] \"A\" X\n"
    "BO_ 512 Modes: 2 X\n SG_ Mode M : 0|8@1+ (1,0) [0|0] \"\" X\n SG_ A m0 : 8|8@1+ (1,0) [0|0] \"\" X\n"
    " SG_ B m1 : 8|8@1+ (1,0) [0|0] \"\" X\n"
    "BO_ 768 Never: 1 X\n SG_ Heard : 0|8@1+ (1,0) [0|0] \"\" X\n";

/// cantools takes a second to start: a file is read by it once for all tests.
const Scratch kCache;

struct Read {
  std::map<std::string, std::vector<std::pair<double, double>>> samples;
  RecordingFacts facts;
};

Read all_of(PlottedSignals& recorded) {
  Read out;
  std::vector<std::vector<std::pair<double, double>>> samples;
  recorded.read(
      [&](std::size_t signal, double time_s, double value) {
        if (signal >= samples.size()) samples.resize(signal + 1);
        samples[signal].emplace_back(time_s, value);
      },
      [](std::size_t) {});
  samples.resize(recorded.heads().size());
  for (std::size_t k = 0; k < samples.size(); ++k) out.samples[recorded.heads()[k].name] = samples[k];
  out.facts = recorded.facts();
  return out;
}

bool mentions(const RecordingFacts& facts, const std::string& words) {
  return fmt::format("{}", fmt::join(facts.notes, "\n")).find(words) != std::string::npos;
}

}  // namespace

TEST_GROUP(PlottedSignals) {
  Scratch scratch;
  DataFolder data{VOLTLAP_DATA_FOLDER};
  TEST_SETUP() { ::setenv("XDG_CACHE_HOME", kCache.file("cache").c_str(), 1); }
  TEST_TEARDOWN() { ::unsetenv("XDG_CACHE_HOME"); }

  Read can(const std::string& lines) {
    const SignalSources sources{scratch.write("a.log", lines), {scratch.write("a.dbc", kDbc)}, {}};
    return all_of(*open_signals(sources, data));
  }
  Read table(const std::string& text) { return all_of(*open_signals({scratch.write("a.csv", text), {}, {}}, data)); }
};

TEST(PlottedSignals, FramesGiveTheirSignalsSecondsAfterTheBeginning) {
  const Read read =
      can("(1700000000.000000) can0 100#A00F9CFF00000000\n(1700000000.500000) can0 100#AA0F000000000000\n");
  const auto& voltage = read.samples.at("Bms.Voltage");
  LONGS_EQUAL(2, voltage.size());
  DOUBLES_EQUAL(0.5, voltage[1].first, 1e-6);
  DOUBLES_EQUAL(401.0, voltage[1].second, 1e-9);
  DOUBLES_EQUAL(-10.0, read.samples.at("Bms.Current")[0].second, 1e-9);
  STRCMP_EQUAL("2023-11-14 22:13:20.000 UTC", read.facts.start.c_str());
  DOUBLES_EQUAL(0.5, read.facts.duration_s, 1e-6);
}

TEST(PlottedSignals, AMultiplexedSignalIsThereInItsCaseOnly) {
  const Read read = can("(1.0) can0 200#0005\n(1.1) can0 200#0106\n(1.2) can0 200#0107\n");
  LONGS_EQUAL(1, read.samples.at("Modes.A").size());
  LONGS_EQUAL(2, read.samples.at("Modes.B").size());
  STRCMP_EQUAL("", read.facts.start.c_str());
}

TEST(PlottedSignals, ACodeForNoMeasurementIsASampleWithoutAValue) {
  const Read read = can("(1.0) can0 100#A00F000000000000\n(1.1) can0 100#FFFF000000000000\n");
  CHECK(std::isnan(read.samples.at("Bms.Voltage")[1].second));
}

TEST(PlottedSignals, AStateThatIsCalledFaultIsAState) {
  const std::string names = "VAL_ 512 A 0 \"Off\" 1 \"Drive\" 5 \"Fault\" ;\nVAL_ 256 Voltage 4000 \"SNA\" ;\n";
  const SignalSources sources{scratch.write("a.log", "(1.0) can0 200#0005\n(1.1) can0 100#A00F000000000000\n"),
                              {scratch.write("n.dbc", kDbc + names)},
                              {}};
  const auto recorded = open_signals(sources, data);
  const Read read = all_of(*recorded);
  DOUBLES_EQUAL(5.0, read.samples.at("Modes.A")[0].second, 0.0);
  STRCMP_EQUAL("Fault", recorded->heads()[1].states.at(5.0).c_str());
  CHECK(std::isnan(read.samples.at("Bms.Voltage")[0].second));
}

TEST(PlottedSignals, TheSameFrameOnTwoBusesIsTwoSignals) {
  const Read read = can("(1.0) can0 100#A00F000000000000\n(1.1) can1 100#000A000000000000\n(1.2) can0 200#0005\n");
  LONGS_EQUAL(1, read.samples.at("can0:Bms.Voltage").size());
  LONGS_EQUAL(1, read.samples.at("can1:Bms.Voltage").size());
  LONGS_EQUAL(1, read.samples.at("Modes.Mode").size());
}

TEST(PlottedSignals, WhatCannotBeDecodedIsSaid) {
  const Read read = can("(1.0) can0 100#A00F000000000000\n(1.1) can0 7FF#00\nrubbish\n(1.2) can0 200#0005\n");
  CHECK(mentions(read.facts, "1 frames of 1 identifiers stand in no DBC file"));
  CHECK(mentions(read.facts, "0x7FF (1)"));
  CHECK(mentions(read.facts, "line that is no frame"));
}

TEST(PlottedSignals, ARecordingWithoutAFrameOfTheFilesIsRefused) {
  STRCMP_CONTAINS("none with an identifier of the DBC files", complaint([&] { can("(1.0) can0 7FF#00\n"); }).c_str());
}

TEST(PlottedSignals, ATableGivesEveryNumericColumnWithItsUnit) {
  const std::string text = "time_ms,v_v,Speed [km/h],word\n500,3.5,10,a\n1500,,20,b\n";
  const SignalSources sources{scratch.write("b.csv", text), {}, {}};
  const auto recorded = open_signals(sources, data);
  const Read read = all_of(*recorded);
  LONGS_EQUAL(2, recorded->heads().size());
  STRCMP_EQUAL("V", recorded->heads()[0].unit.c_str());
  STRCMP_EQUAL("Speed", recorded->heads()[1].name.c_str());
  STRCMP_EQUAL("km/h", recorded->heads()[1].unit.c_str());
  LONGS_EQUAL(1, read.samples.at("v_v").size());
  DOUBLES_EQUAL(1.0, read.samples.at("Speed")[1].first, 1e-9);
  CHECK(mentions(read.facts, "column word has no number"));
}

TEST(PlottedSignals, ATableWhoseClockStepsBackGoesOn) {
  const Read read = table("t_s,x\n0,1\n10,2\n1,3\n2,4\n");
  const auto& x = read.samples.at("x");
  DOUBLES_EQUAL(10.0, x[2].first, 1e-9);
  DOUBLES_EQUAL(11.0, x[3].first, 1e-9);
  CHECK(mentions(read.facts, "1 x the time steps back, first in line 4"));
}

TEST(PlottedSignals, ATableWithoutATimeCountsItsRows) {
  const Read read = table("a,b\n5,1\n3,2\n");
  LONGS_EQUAL(2, read.samples.size());
  DOUBLES_EQUAL(1.0, read.samples.at("b")[1].first, 0.0);
  CHECK(mentions(read.facts, "the rows are counted"));
}

TEST(PlottedSignals, AMapGivesItsRolesInSi) {
  const std::string map = scratch.write("m.toml",
                                        "[roles]\ntime = {column = \"t\", unit = \"s\"}\n"
                                        "current = {column = \"I\", unit = \"mA\", discharge = \"+\"}\n"
                                        "voltage = {column = \"U\", unit = \"mV\"}\n");
  const auto recorded =
      open_signals({scratch.write("c.csv", "t,I,U\n0,1000,3700\n1,2000,3650\n2,1000,3690\n"), {}, map}, data);
  const Read read = all_of(*recorded);
  DOUBLES_EQUAL(2.0, read.samples.at("current")[1].second, 1e-9);
  DOUBLES_EQUAL(3.65, read.samples.at("voltage")[1].second, 1e-9);
  STRCMP_EQUAL("A", recorded->heads()[0].unit.c_str());
}

TEST(PlottedSignals, AMapBesideDbcFilesSaysHowOftenFramesWithoutStampsCome) {
  const std::string map = scratch.write("p.toml",
                                        "[roles]\npack_voltage = {frame = 0x100, signal = \"Voltage\", unit = \"V\", "
                                        "dbc = \"a.dbc\", period_s = 0.5}\n");
  const SignalSources sources{scratch.write("a.slcan", "t1008A00F000000000000\nt1008AA0F000000000000\n"),
                              {scratch.write("a.dbc", kDbc)},
                              map};
  const Read read = all_of(*open_signals(sources, data));
  DOUBLES_EQUAL(0.5, read.samples.at("Bms.Voltage")[1].first, 1e-9);
}

TEST(PlottedSignals, AFrameThatItsFileDescribesWronglyIsNamedAndTheOthersAreRead) {
  const std::string dbc = scratch.write("b.dbc", std::string(kDbc) +
                                                     "BO_ 300 Wrong: 2 X\n SG_ S : 0|32@1+ (1,0) [0|0] \"\" X\n");
  const std::string lines = "(1.0) can0 100#A00F000000000000\n(1.1) can0 12C#0000\n";
  const SignalSources sources{scratch.write("a.log", lines), {dbc}, {}};
  const Read read = all_of(*open_signals(sources, data));
  LONGS_EQUAL(1, read.samples.at("Bms.Voltage").size());
  CHECK(mentions(read.facts, "1 frames 0x12C Wrong are not shown"));
}
