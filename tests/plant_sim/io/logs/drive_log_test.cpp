// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cmath>

#include "drive_frames.hpp"
#include "io/logs/cell_log.hpp"

#include <CppUTest/TestHarness.h>

using namespace voltlap::plant;

TEST_GROUP_BASE(DriveLog, DriveFrames){};

TEST(DriveLog, FramesBecomeChannelsWithTheirOwnStamps) {
  const DriveLog log = read(square(100), pack_map());
  const Channel& current = log.channels.at("current");
  LONGS_EQUAL(100, current.size());
  DOUBLES_EQUAL(1000.25, current.time_s[25], 1e-9);
  DOUBLES_EQUAL(20.0, current.value[25], 1e-9);
  DOUBLES_EQUAL(98.0, log.channels.at("pack_voltage").value[25], 1e-9);
  CHECK(log.defects.empty());
  CHECK(log.masked.empty());
}

TEST(DriveLog, AfterARecorderThatStartedAnewTheStateOfACellIsLeftFree) {
  const DriveLog log = read(square(200, 100.0) + square(200, 0.0), pack_map());
  LONGS_EQUAL(1, log.restarts_s.size());
  LogOptions options;
  options.cells_in_series = 24;
  const CellLog cell = cell_log_of(log, options);
  LONGS_EQUAL(400, cell.rows());
  for (std::size_t row = 0; row < cell.rows(); ++row) CHECK_EQUAL(row == 200, cell.gap[row]);
  // A clock that is set while the recording goes on hides nothing.
  const CellLog set = cell_log_of(read(square(200, 1000.0) + square(200, 900.0), pack_map()), options);
  CHECK(std::none_of(set.gap.begin(), set.gap.end(), [](bool gap) { return gap; }));
}

TEST(DriveLog, AbsoluteClockStartsAtTheFirstFrame) {
  const DriveLog log = read(square(10, 1.7e9), pack_map());
  DOUBLES_EQUAL(1.7e9, log.origin_s, 1e-3);
  DOUBLES_EQUAL(0.0, log.channels.at("current").time_s[0], 1e-6);
}

TEST(DriveLog, FramesWithAWrongChecksumAreMaskedAndCounted) {
  std::string text = square(50);
  text += pack_frame(1000.50, 9999, 1000, 50, false) + pack_frame(1000.51, 0, 1000, 51);
  const DriveLog log = read(text, pack_map());
  CHECK(std::isnan(log.channels.at("current").value[50]));
  LONGS_EQUAL(1, defect(log, "checksum does not hold")->count);
  CHECK(is_masked(log, "current", "checksum does not hold"));
  CHECK(is_masked(log, "pack_voltage", "checksum does not hold"));
}

TEST(DriveLog, CounterThatJumpsTellsLostFrames) {
  const DriveLog log = read(pack_frame(1.00, 0, 1000, 14) + pack_frame(1.01, 0, 1000, 15) +
                                pack_frame(1.04, 0, 1000, 2) + pack_frame(1.05, 0, 1000, 3),
                            pack_map());
  LONGS_EQUAL(2, defect(log, "lost frames by the counter")->count);
  CHECK(is_masked(log, "current", "lost frames by the counter"));
}

TEST(DriveLog, LongPauseIsAGap) {
  const DriveLog log = read(square(50) + pack_frame(1002.0, 0, 1000, 2), pack_map());
  CHECK(is_masked(log, "current", "gap"));
  DOUBLES_EQUAL(1002.0, log.masked.back().end_s, 1e-9);
}

TEST(DriveLog, CellsOneAFrameAreToldByTheirIndex) {
  const RoleMap map =
      map_of("\"cell_voltage_<n>\" = {frame = 0x101, signal = \"V\", index = \"Id\", dbc = \"a.dbc\"}\n");
  std::string text;
  for (int k = 0; k < 30; ++k) text += cell_frame(0.01 * k, k % 3, 40000 + k % 3);
  const DriveLog log = read(text, map);
  LONGS_EQUAL(3, log.numbered("cell_voltage_").size());
  DOUBLES_EQUAL(4.0002, log.channels.at("cell_voltage_3").value[0], 1e-9);
  DOUBLES_EQUAL(0.02, log.channels.at("cell_voltage_3").time_s[0], 1e-9);
}

TEST(DriveLog, ImpossibleCellsAndInvalidCodesAreMaskedAndPaddingSlotsLeftOut) {
  const RoleMap map = map_of(
      "\"cell_voltage_<n>\" = {frame = 0x101, signal = \"V\", index = \"Id\", dbc = \"a.dbc\", "
      "invalid = [6.5535]}\n");
  std::string text;
  const int readings[] = {40000, 0, 5100, 44800, 65535, 40000};  // 0.0, 0.51, 4.48 V and all ones
  double time = 0.0;
  for (const int raw : readings) {
    text += cell_frame(time, 0, raw) + cell_frame(time + 0.01, 1, 0);
    time += 0.02;
  }
  const DriveLog log = read(text, map);
  LONGS_EQUAL(3, defect(log, "impossible value")->count);
  LONGS_EQUAL(1, defect(log, "invalid code")->count);
  LONGS_EQUAL(6, log.channels.at("cell_voltage_1").size());
  POINTERS_EQUAL(nullptr, log.find("cell_voltage_2"));
  STRCMP_EQUAL("cell_voltage_2", defect(log, "no usable value")->channel.c_str());
}

TEST(DriveLog, NumberedSignalsAreOneEntry) {
  const RoleMap map = map_of("\"cell_voltage_<n>\" = {frame = 0x102, signal = \"Cell<n>\", dbc = \"a.dbc\"}\n");
  const DriveLog log = read("(1.0) c 102#009C400000000000\n(1.1) c 102#019C410000000000\n", map);
  DOUBLES_EQUAL(4.0, log.channels.at("cell_voltage_1").value.at(0), 1e-9);
  DOUBLES_EQUAL(1.1, log.channels.at("cell_voltage_2").time_s.at(0), 1e-9);
}

TEST(DriveLog, ShortFramesAreMaskedAndMissingFramesNamed) {
  const RoleMap map = map_of(
      "current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\"}\n"
      "pack_voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\"}\n");
  const DriveLog log = read("(1.0) c 100#0001\n(1.1) c 100#00\n", map);
  CHECK(is_masked(log, "current", "frame too short for the signal"));
  STRCMP_CONTAINS("0x101", defect(log, "frame never seen")->text.c_str());
}

TEST(DriveLog, AnotherRecordingIsJoinedOnTime) {
  const std::string table = scratch.write("tc.csv", "t,tc\n1000.0,20\n1000.5,21\n");
  const RoleMap map = map_of(
      "current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\"}\npack_voltage = {frame = 0x100, signal = \"U\", "
      "dbc = "
      "\"a.dbc\"}\ntemperature_1 = {file = \"tc.csv\", column = \"tc\", time = \"t\", unit = \"degC\"}\n");
  const DriveLog log = read(square(100), map);
  DOUBLES_EQUAL(1000.5, log.channels.at("temperature_1").time_s.at(1), 0.0);
  STRCMP_CONTAINS("tc.csv", log.notes.at(0).c_str());
}

TEST(DriveLog, RecordingThatDoesNotOverlapIsRefusedUntilItIsShifted) {
  scratch.write("tc.csv", "t,tc\n0.0,20\n0.5,21\n");
  const std::string roles =
      "current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\"}\n"
      "temperature_1 = {file = \"tc.csv\", column = \"tc\", time = \"t\"";
  const RoleMap apart = map_of(roles + "}\n");
  STRCMP_CONTAINS("shift_s", complaint([&] { (void)read(square(100), apart); }).c_str());
  const DriveLog log = read(square(100), map_of(roles + ", shift_s = 1000}\n"));
  DOUBLES_EQUAL(1000.5, log.channels.at("temperature_1").time_s.at(1), 0.0);
}

TEST(DriveLog, LongTableIsSpreadByItsIndex) {
  scratch.write("cells.csv", "t,n,value\n1000.0,1,4.0\n1000.1,2,3.9\n1000.2,1,3.8\n");
  const DriveLog log = read(square(100), map_of("current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\"}\n"
                                                "\"cell_voltage_<n>\" = {file = \"cells.csv\", column = \"value\", "
                                                "index = \"n\", time = \"t\"}\n"));
  LONGS_EQUAL(2, log.channels.at("cell_voltage_1").size());
  DOUBLES_EQUAL(3.9, log.channels.at("cell_voltage_2").value.at(0), 1e-12);
}

TEST(DriveLog, TableWithPlainNamesNeedsNoMap) {
  std::string text = "time_s,pack_current_a,pack_voltage_v,cell_voltage_1_v,cell_voltage_2_v,temperature_1_c\n";
  for (int k = 0; k < 40; ++k) {
    const bool on = k / 10 % 2 == 1;
    text += fmt::format("{},{},{},{},{},25\n", k, on ? 10 : 0, on ? 7.8 : 8.0, on ? 3.9 : 4.0, k == 5 ? 0.0 : 4.0);
  }
  const DriveLog log = read_drive_log(scratch.write("pack.csv", text), nullptr, data);
  LONGS_EQUAL(2, log.numbered("cell_voltage_").size());
  CHECK(is_masked(log, "cell_voltage_2", "impossible value"));
  CHECK(log.find("temperature_1") != nullptr);
}

TEST(DriveLog, AnOptionalColumnMayBeMissingAndNoOther) {
  const auto roles_of = [&](const char* columns, const char* optional) {
    std::string text = std::string(columns) + "\n";
    for (int k = 0; k < 40; ++k) {
      const bool on = k / 10 % 2 == 1;
      text += fmt::format("{},{},{},{}\n", k, on ? 1 : 0, on ? 3.9 : 4.0, 0.01 * k);
    }
    const RoleMap map = map_of(fmt::format("time = {{column = \"t\"}}\ncurrent = {{column = \"I\"}}\n"
                                           "voltage = {{column = \"U\"}}\ncharge_ah = {{column = \"Q\"{}}}\n",
                                           optional));
    return read_drive_log(scratch.write("rows.csv", text), &map, data).find("charge_ah") != nullptr;
  };
  CHECK(roles_of("t,I,U,Q", ", optional = true"));
  CHECK_FALSE(roles_of("t,I,U,X", ", optional = true"));
  STRCMP_CONTAINS("Q", complaint([&] { (void)roles_of("t,I,U,X", ""); }).c_str());
}

TEST(DriveLog, CellLogFromFramesHoldsTheCurrentOnly) {
  std::string text;
  for (int k = 0; k < 100; ++k) {
    const bool on = k / 20 % 2 == 1;
    text += pack_frame(1.0 + 0.02 * k, on ? 200 : 0, 0, k) + cell_frame(1.01 + 0.02 * k, 0, on ? 39000 : 40000);
  }
  const RoleMap map = map_of(
      "current = {frame = 0x100, signal = \"I\", dbc = \"a.dbc\"}\n"
      "voltage = {frame = 0x101, signal = \"V\", dbc = \"a.dbc\"}\n");
  const CellLog log = read_cell_log(scratch.write("a.log", text), &map, data);
  LONGS_EQUAL(200, log.rows());
  CHECK(std::isnan(log.voltage_v[0]));
  DOUBLES_EQUAL(4.0, log.voltage_v[1], 1e-9);
  DOUBLES_EQUAL(20.0, log.current_a[41], 1e-9);
}

TEST(DriveLog, MapThatDoesNotFitIsRefusedByNames) {
  const auto why = [&](const std::string& roles) {
    const RoleMap map = map_of(roles);
    return complaint([&] { (void)read(square(20), map); });
  };
  STRCMP_CONTAINS("one of I, U", why("current = {frame = 0x100, signal = \"J\", dbc = \"a.dbc\"}\n").c_str());
  STRCMP_CONTAINS("0x7FF", why("current = {frame = 0x7FF, signal = \"I\", dbc = \"a.dbc\"}\n").c_str());
  STRCMP_CONTAINS("absent.dbc", why("current = {frame = 0x100, signal = \"I\", dbc = \"absent.dbc\"}\n").c_str());
  STRCMP_CONTAINS("That recording is a CAN log", why("current = {column = \"I\"}\n").c_str());
}

TEST(DriveLog, UnknownCanRecordingIsAnsweredWithADraftMap) {
  const std::string path = scratch.write("a.log", square(20));
  const std::string message = complaint([&] { (void)read_drive_log(path, nullptr, data); });
  STRCMP_CONTAINS("current = {frame = 0x?", message.c_str());
  STRCMP_CONTAINS("0x100, 8 bytes, 20 frames, every 10 ms", message.c_str());
}

TEST(DriveLog, HeldValueGrowsOld) {
  const Channel channel{"current", "", {0.0, 1.0, 2.0}, {1.0, std::nan(""), 3.0}};
  const auto held = held_at(channel, {-1.0, 0.5, 1.5, 2.0, 9.0}, 1.2);
  CHECK(std::isnan(held[0]));
  DOUBLES_EQUAL(1.0, held[1], 0.0);
  CHECK(std::isnan(held[2]));
  DOUBLES_EQUAL(3.0, held[3], 0.0);
  CHECK(std::isnan(held[4]));
}
